#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/analytic/analytic_file.h"
#include "converters/files/format_table.h"
#include "converters/models/analytic.h"
#include "formats/core/named.h"
#include "tools/commands/commands.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

const char* const kKurtDescription = "Kurt model of a built-in material, or of parameters in a JSON file";
constexpr std::size_t kColumns = 120;

/// What goes beyond reading and writing, in the words of the list.
constexpr std::array kCapabilityNames = {
    Named{"parts", Capability::kParts}, Named{"levels of detail", Capability::kLevels},
    Named{"into bundles", Capability::kBundled}, Named{"many materials", Capability::kManyMaterials},
    Named{"how it came to be", Capability::kMetadata}};
constexpr std::array kKindNames = {Named{"number", OptionKind::kNumber}, Named{"count", OptionKind::kCount},
                                   Named{"choice", OptionKind::kChoice}, Named{"flag", OptionKind::kFlag},
                                   Named{"text", OptionKind::kText}};
constexpr std::array kUseNames = {Named{"read", OptionUse::kRead}, Named{"write", OptionUse::kWrite},
                                  Named{"both", OptionUse::kBoth}};

std::vector<std::string> capabilities_of(const Format& format) {
  std::vector<std::string> names;
  for (const auto& [name, capability] : kCapabilityNames) {
    if (format.capabilities.has(capability)) names.emplace_back(name);
  }
  return names;
}

Json limits_json(double least, double most) {
  return {{"least", least}, {"most", most < std::numeric_limits<double>::max() ? Json(most) : Json()}};
}

Json option_json(const OptionSpec& option) {
  Json json = {{"name", option.name},
               {"kind", name_of(kKindNames, option.kind)},
               {"use", name_of(kUseNames, option.use)},
               {"meaning", option.meaning}};
  if (!option.unit.empty()) json["unit"] = option.unit;
  if (!option.fallback.empty()) json["default"] = option.fallback;
  if (option.kind == OptionKind::kChoice) {
    json["choices"] = Json::array();
    for (const std::string_view choice : option.choices) json["choices"].push_back(choice);
  }
  if (option.kind == OptionKind::kNumber) {
    json["range"] = limits_json(option.range.least, option.range.most);
    json["range"]["open"] = option.range.open;
  }
  if (option.kind == OptionKind::kCount) {
    json["range"] = {{"least", option.counts.least}, {"most", option.counts.most}};
  }
  return json;
}

Json format_json(const Format& format) {
  const Holds& holds = format.holds;
  Json json = {{"name", format.name},
               {"extension", format.extension},
               {"description", format.description},
               {"page", format.page},
               {"read", format.capabilities.has(Capability::kRead)},
               {"write", format.capabilities.has(Capability::kWrite)},
               {"capabilities", capabilities_of(format)},
               {"holds",
                {{"anisotropic", holds.anisotropic},
                 {"non_reciprocal", holds.non_reciprocal},
                 {"unmeasured", holds.unmeasured},
                 {"negatives", holds.negatives},
                 {"channels", holds.channels},
                 {"values", holds.values}}}};
  json["options"] = Json::array();
  for (const OptionSpec& option : format.options) json["options"].push_back(option_json(option));
  return json;
}

void print_as_json() {
  Json rows = Json::array();
  for (const Format& format : formats()) rows.push_back(format_json(format));
  const Json kurt = {{"name", "kurt"},
                     {"prefix", kKurtPrefix},
                     {"description", kKurtDescription},
                     {"materials", kurt_material_names()}};
  print_json({{"formats", rows}, {"models", Json::array({kurt})}});
}

std::string mark(bool yes) { return yes ? "yes" : "-"; }

/// Lines of at most so many characters, broken at spaces.
std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  while (text.size() > width) {
    const std::size_t space = text.rfind(' ', width);
    if (space == std::string_view::npos || space == 0) break;
    lines.emplace_back(text.substr(0, space));
    text.remove_prefix(space + 1);
  }
  lines.emplace_back(text);
  return lines;
}

/// A table whose last column takes what room the others leave, in as many lines as it needs.
void print_wrapped(const std::vector<std::vector<std::string>>& rows) {
  std::size_t left = kColumns;
  for (std::size_t k = 0; k + 1 < rows[0].size(); ++k) {
    std::size_t widest = 0;
    for (const auto& row : rows) widest = std::max(widest, row[k].size());
    left -= std::min(left, widest + 2);
  }
  Table table;
  for (std::vector<std::string> row : rows) {
    for (const std::string& line : wrapped(row.back(), left)) {
      row.back() = line;
      table.add(row);
      for (std::string& cell : row) cell.clear();
    }
  }
  table.print();
}

void print_directions() {
  std::vector<std::vector<std::string>> rows = {{"format", "extension", "read", "write", "description"}};
  for (const Format& format : formats()) {
    rows.push_back({std::string(format.name), std::string(format.extension),
                    mark(format.capabilities.has(Capability::kRead)), mark(format.capabilities.has(Capability::kWrite)),
                    std::string(format.description)});
  }
  rows.push_back({"kurt", std::string(kKurtPrefix) + "NAME", mark(true), mark(false), kKurtDescription});
  print_wrapped(rows);
}

void print_holds() {
  std::vector<std::vector<std::string>> rows = {
      {"can hold", "anisotropic", "non-reciprocal", "unmeasured", "negatives", "channels", "values"}};
  for (const Format& format : formats()) {
    const Holds& holds = format.holds;
    rows.push_back({std::string(format.name), mark(holds.anisotropic), mark(holds.non_reciprocal),
                    mark(holds.unmeasured), mark(holds.negatives), std::string(holds.channels),
                    std::string(holds.values)});
  }
  print_wrapped(rows);
}

void print_capabilities() {
  std::vector<std::vector<std::string>> rows = {{"and", "what else"}};
  for (const Format& format : formats()) {
    if (!capabilities_of(format).empty()) rows.push_back({std::string(format.name), join(capabilities_of(format))});
  }
  print_wrapped(rows);
}

void print_as_table() {
  print_directions();
  print("\n");
  print_holds();
  print("\n");
  print_capabilities();
  print(
      "\nFiles are recognised by content when read; the extension chooses what is written. What of a material a "
      "format\n"
      "cannot hold is told when it is written. 'sbrdf convert --help' lists the options of each.\n");
  const std::string models =
      fmt::format("{0}NAME is one of {1}. {0}FILE.json reads the parameters of any number of lobes.", kKurtPrefix,
                  join(kurt_material_names()));
  for (const std::string& line : wrapped(models, kColumns)) print(line + "\n");
}

}  // namespace

void add_formats(CLI::App& program, int& exit_code) {
  auto* command =
      program.add_subcommand("formats", "Lists what can be read and written, and what each format can hold.");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON, with the options of each format");
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
