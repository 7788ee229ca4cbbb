#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "converters/files/format_table.h"
#include "converters/files/kurt/kurt_file.h"
#include "converters/models/kurt.h"
#include "tools/commands/commands.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

const char* const kKurtDescription = "Kurt model of a built-in material, or of parameters in a JSON file";

void print_as_json() {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Format& format : formats()) {
    rows.push_back({{"name", format.name},
                    {"extension", format.extension},
                    {"description", format.description},
                    {"read", format.capabilities.has(Capability::kRead)},
                    {"write", format.capabilities.has(Capability::kWrite)}});
  }
  const nlohmann::ordered_json kurt = {{"name", "kurt"},
                                       {"prefix", kKurtPrefix},
                                       {"description", kKurtDescription},
                                       {"materials", kurt_material_names()}};
  print_json({{"formats", rows}, {"models", nlohmann::ordered_json::array({kurt})}});
}

void print_as_table() {
  const auto mark = [](bool yes) { return yes ? "yes" : "-"; };
  Table table;
  table.add({"format", "extension", "read", "write", "description"});
  for (const Format& format : formats()) {
    table.add({std::string(format.name), std::string(format.extension),
               mark(format.capabilities.has(Capability::kRead)), mark(format.capabilities.has(Capability::kWrite)),
               std::string(format.description)});
  }
  table.add({"kurt", std::string(kKurtPrefix) + "NAME", mark(true), mark(false), kKurtDescription});
  table.print();
  print("\nFiles are recognised by content when read; the extension chooses what is written.\n");
  print(fmt::format("{0}NAME is one of {1}.\n{0}FILE.json reads the parameters of any number of lobes.\n", kKurtPrefix,
                    join(kurt_material_names())));
}

}  // namespace

void add_formats(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("formats", "Lists what can be read and written.");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  sbrdf formats");
  command->callback([json, &exit_code] {
    if (*json) {
      print_as_json();
    } else {
      print_as_table();
    }
    exit_code = 0;
  });
}

}  // namespace sbrdf::internal
