#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "converters/audit/audit.h"
#include "converters/files/by_name.h"
#include "formats/os/files.h"
#include "formats/os/interrupt.h"
#include "tools/audit/audit_journal.h"
#include "tools/audit/audit_report.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/conversion/conversion.h"
#include "tools/conversion/folder.h"
#include "tools/io/columns.h"
#include "tools/io/outputs.h"
#include "tools/io/report_folder.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastTarget = 0.01;
constexpr double kMostTarget = 100;

struct AuditCommand {
  std::vector<std::string> inputs;
  std::string out;
  AuditSettings settings;
  bool json = false;
  Options given;  ///< of reading
};

/// A report of an audit lies in it, none of whose files is a material.
bool is_report(const fs::path& folder) {
  std::error_code failed;
  return fs::is_directory(folder / AuditJournal::kFolder, failed);
}

/// Of each input that is a folder, the files in it and below.
Result<std::vector<std::string>> materials_of(const AuditCommand& command) {
  std::vector<std::string> materials;
  for (const std::string& input : command.inputs) {
    std::error_code failed;
    if (!fs::is_directory(input, failed)) {
      materials.push_back(input);
      continue;
    }
    const auto naming = [&](Error error) {
      error.message = input + ": " + error.message;
      return error;
    };
    if (!command.out.empty() && whole_path(input) == whole_path(command.out)) {
      return naming(
          usage_error("is the folder that is read: the next run would read the report; choose another --out"));
    }
    const Result<FolderContent> content = list_folder(input, {".sbrdf", true, {command.out}});
    if (!content) return naming(content.error());
    for (const FolderFile& file : content->files) {
      const fs::path path = fs::path(input) / file.name;
      if (!is_report(path.parent_path())) materials.push_back(path.string());
    }
  }
  std::vector<std::string> places;
  for (const std::string& material : materials) {
    places.push_back(exists(material) ? whole_path(material).string() : material);
  }
  std::sort(places.begin(), places.end());
  const auto twice = std::adjacent_find(places.begin(), places.end());
  if (twice != places.end()) return usage_error(*twice + ": is given twice");
  return materials;
}

/// For pages that are kept: of folders only their names.
std::string told_command(const AuditCommand& command) {
  const auto quoted = [](const std::string& text) {
    if (text.find_first_of(" '\"\\$`") == std::string::npos) return text;
    std::string all = "'";
    for (const char c : text) all += c == '\'' ? "'\\''" : std::string(1, c);
    return all + "'";
  };
  std::string text = "sbrdf audit";
  for (const std::string& input : command.inputs) {
    text += " " + quoted(exists(input) ? whole_path(input).filename().string() : input);
  }
  for (const double target : command.settings.targets) text += fmt::format(" --rel-l1 {:g}", target);
  for (const std::string& method : command.settings.methods) text += " --method " + quoted(method);
  if (command.settings.directions != AuditSettings().directions) {
    text += fmt::format(" --count {}", command.settings.directions);
  }
  if (const std::string options = options_text(command.given); !options.empty()) text += " " + options;
  if (!command.out.empty()) text += " --out " + quoted(whole_path(command.out).filename().string());
  return text;
}

void print_rows(const TextRows& rows) {
  Table table;
  for (const std::vector<std::string>& row : rows) table.add(row);
  table.print();
}

/// One run: what is done is kept, what fails is told and does not stop the rest.
class AuditRunner {
 public:
  explicit AuditRunner(const AuditCommand& command)
      : command_(command), folder_(command.out, "audit"), journal_(command.out, command.settings, command.given) {
    run_ = {command.settings, told_command(command), SBRDF_VERSION};
  }

  /// The exit code.
  int run() {
    const Result<std::vector<std::string>> materials = materials_of(command_);
    if (!materials) return report_error("", materials.error());
    if (Status used = check_options_of(*materials); !used) return report_error("", used.error());
    if (!command_.out.empty()) {
      Status ready = folder_.prepare(audit_files(command_.settings), *materials);
      if (ready) ready = journal_.start();
      if (!ready) {
        folder_.take_back();
        return report_error(command_.out, ready.error());
      }
    }
    is_single_ = materials->size() == 1;
    for (std::size_t k = 0; k < materials->size(); ++k) {
      const std::string label = is_single_ ? "audit" : fmt::format("audit {}/{}", k + 1, materials->size());
      if (!add((*materials)[k], label)) return report_error("", interrupted_error());
    }
    if (Status written = write(); !written) return report_error(command_.out, written.error());
    tell();
    return exit_code_;
  }

 private:
  [[nodiscard]] Status check_options_of(const std::vector<std::string>& materials) const {
    if (Status known = check_methods(command_.settings.methods); !known) return known;
    return check_reading_options(command_.given, materials);
  }

  /// False after a signal.
  bool add(const std::string& name, const std::string& label) {
    if (interrupted()) return false;
    AuditedMaterial material = {name, {}, {}};
    if (Result<std::vector<AuditRow>> rows = audit(name, label)) {
      // With the digits that a journal has, so that a resumed run says the same.
      material.rows = audit_rows_of(audit_rows_json(*rows)).value_or(*rows);
    } else {
      if (interrupted()) return false;
      const int failed = report_error(name, rows.error());
      if (exit_code_ == 0) exit_code_ = failed;
      material.failure = rows.error();
    }
    if (!command_.json && !is_single_ && !material.failure) {
      print(fmt::format("{}: {}\n", one_line(name), smallest_text(material, command_.settings)));
      std::ignore = flush_output();  // what is lost is told at the end
    }
    materials_.push_back(std::move(material));
    return true;
  }

  [[nodiscard]] Result<std::vector<AuditRow>> audit(const std::string& name, const std::string& label) const {
    const Result<OpenedSource> opened = open_source(name, command_.given);
    if (!opened) return opened.error();
    std::unique_ptr<AuditMemory> memory;
    if (!command_.out.empty()) {
      memory = journal_.memory_of(name, [&](const Error& error) { print_note(name, error.message); });
    }
    ProgressBar bar(label + " " + one_line(name, 40));
    return audit_material(*opened->source, command_.settings, memory.get(), bar.progress());
  }

  [[nodiscard]] Status write() const {
    return command_.out.empty() ? ok_status() : folder_.write(audit_report(materials_, run_));
  }

  void tell() const {
    if (command_.json) {
      print_json(audit_json(materials_, run_));
      return;
    }
    const bool some = std::any_of(materials_.begin(), materials_.end(), [](const auto& one) { return !one.failure; });
    for (const double target : command_.settings.targets) {
      if (!some) break;
      print(fmt::format("\n{:g} % relative L1 off the grid\n", target));
      print_rows(is_single_ ? material_table(materials_.front(), target) : totals_table(materials_, target));
    }
  }

  const AuditCommand& command_;
  ReportFolder folder_;
  AuditJournal journal_;
  AuditRun run_;
  std::vector<AuditedMaterial> materials_;
  bool is_single_ = false;
  int exit_code_ = 0;
};

int run_audit(AuditCommand command) {
  std::vector<double>& targets = command.settings.targets;
  // With the digits that reports and journal have.
  for (double& target : targets) target = std::strtod(figure_text(target).c_str(), nullptr);
  std::sort(targets.begin(), targets.end(), std::greater<>());
  targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
  return AuditRunner(command).run();
}

}  // namespace

void add_audit(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("audit", "What storage a material needs, and what is lost: every way to keep it.");
  const auto command = std::make_shared<AuditCommand>();
  app->add_option("IN", command->inputs,
                  "Files of any readable format, folders of them, kurt:NAME or BUNDLE.sbrdfz:NAME")
      ->required();
  app->add_option("--rel-l1", command->settings.targets,
                  "Error that each way is to keep to, relative L1 off the grid, 0.01 to 100 %; may be given several "
                  "times")
      ->check([](const std::string& text) {
        const Result<double> number = number_within(text, {kLeastTarget, kMostTarget});
        return number ? std::string() : number.error().message;
      })
      ->type_name("P")
      ->allow_extra_args(false)
      ->default_str("5, 2");
  app->add_option("--method", command->settings.methods,
                  "Only this way, such as \"table, zstd\" (specs/audit.md names all); may be given several times")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_count(*app, "--count", command->settings.directions, {1000, 10'000'000},
            "Directions that errors are measured on, off the grid and as many on it");
  app->add_option("--out", command->out,
                  "Also write tables (CSV, JSON), a page (Markdown) and charts (SVG) to this folder; made if missing. "
                  "A run that was interrupted goes on where it was")
      ->type_name("DIR");
  app->add_flag("--json", command->json, "Print JSON");
  add_reading_options(*app, command->given);
  app->footer(
      "Of each way the smallest is looked for that keeps to the error; bytes are of all files. The manual is "
      "specs/audit.md.\n\n"
      "Examples:\n  sbrdf audit material.bsdf --rel-l1 5\n  sbrdf audit measurements --out audit");
  app->callback([command, &exit_code] { exit_code = run_audit(*command); });
}

}  // namespace sbrdf::internal
