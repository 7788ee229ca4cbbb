#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "converters/paper/reproduce.h"
#include "converters/slicing/names.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

struct ReproduceOptions {
  AccuracyOptions accuracy;
  PlacementOptions placement;
  std::string domain = "linear";
  std::string refine = "measured";
  std::vector<std::string> methods;
  std::string kernel = "inverse-multiquadric";
  std::string counts;
  std::string csv;
  std::string material = "fabric112";
  std::string folder;
  bool json = false;
};

SliceOptions chosen_slices(const ReproduceOptions& options) {
  SliceOptions slices = options.accuracy.slices;
  if (options.accuracy.automatic) return slices;
  slices.domain = value_of(kDomainNames, options.domain);
  slices.refinement = value_of(kRefinementNames, options.refine).value_or(slices.refinement);
  return slices;
}

Status check_csv(const ReproduceOptions& options) {
  return options.csv.empty() ? ok_status() : check_output(options.csv, nullptr, {});
}

int write_csv(const ReproduceOptions& options, const std::string& text) {
  if (options.csv.empty()) return 0;
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  if (Status written = write_file_atomically(options.csv, bytes); !written) {
    return report_error(options.csv, written.error());
  }
  return 0;
}

std::string accuracy_csv(const std::vector<AccuracyRow>& rows) {
  std::string text =
      "material,method,samples,structure,mre_percent,paper_mre_percent,ratio,exchanged_in_paper,"
      "off_grid_mre_percent,off_grid_rel_l1_percent,false_values\n";
  for (const AccuracyRow& row : rows) {
    text += fmt::format("{},{},{},\"{}\",{:.6g},{},{:.6g},{},{:.6g},{:.6g},{}\n", row.material,
                        name_of(kPaperMethodNames, row.method), row.samples, row.structure, row.mre_percent,
                        row.paper_mre_percent, row.mre_percent / row.paper_mre_percent, row.exchanged_in_paper ? 1 : 0,
                        row.off_grid_mre_percent, row.off_grid_rel_l1_percent, row.false_values);
  }
  return text;
}

bool has_method(const std::vector<AccuracyRow>& rows, PaperMethod method) {
  return std::any_of(rows.begin(), rows.end(), [&](const AccuracyRow& row) { return row.method == method; });
}

Json accuracy_json(const std::vector<AccuracyRow>& rows) {
  Json json = {{"rows", Json::array()}};
  for (const AccuracyRow& row : rows) {
    json["rows"].push_back({{"material", row.material},
                            {"method", name_of(kPaperMethodNames, row.method)},
                            {"samples", row.samples},
                            {"structure", row.structure},
                            {"mre_percent", row.mre_percent},
                            {"paper_mre_percent", row.paper_mre_percent},
                            {"ratio", row.mre_percent / row.paper_mre_percent},
                            {"exchanged_in_paper", row.exchanged_in_paper},
                            {"off_grid_mre_percent", row.off_grid_mre_percent},
                            {"off_grid_rel_l1_percent", row.off_grid_rel_l1_percent},
                            {"false_values", row.false_values}});
  }
  for (const auto& [name, method] : kPaperMethodNames) {
    if (!has_method(rows, method)) continue;
    for (const std::uint64_t samples : kPaperCounts) {
      json["geometric_mean_ratio"][std::string(name)][std::to_string(samples)] =
          mean_ratio_to_paper(rows, method, samples);
    }
    const PaperOrdering ordering = ordering_against(rows, method);
    if (method == PaperMethod::kProposed || ordering.cells == 0) continue;
    json["proposed_against"][std::string(name)] = {
        {"better", ordering.proposed_better}, {"cells", ordering.cells}, {"otherwise", ordering.otherwise}};
  }
  return json;
}

void print_orderings(const std::vector<AccuracyRow>& rows) {
  for (const PaperMethod method : {PaperMethod::kBarycentric, PaperMethod::kRbf}) {
    const PaperOrdering ordering = ordering_against(rows, method);
    if (ordering.cells == 0) continue;
    std::string text = fmt::format("proposed better than {} in {} of {}", name_of(kPaperMethodNames, method),
                                   ordering.proposed_better, ordering.cells);
    if (!ordering.otherwise.empty()) text += fmt::format("; not so: {}", fmt::join(ordering.otherwise, ", "));
    print(text + "\n");
  }
}

void print_accuracy(const std::vector<AccuracyRow>& rows, RbfKernel kernel) {
  Table table;
  table.add({"material", "method", "samples", "structure", "MRE [%]", "paper [%]", "ratio", "off grid: MRE [%]",
             "rel. L1 [%]", "false"});
  for (const AccuracyRow& row : rows) {
    table.add({row.material + (row.exchanged_in_paper ? " *" : ""), std::string(name_of(kPaperMethodNames, row.method)),
               format_count(row.samples), row.structure, fmt::format("{:.3f}", row.mre_percent),
               fmt::format("{:.1f}", row.paper_mre_percent),
               fmt::format("{:.3f}", row.mre_percent / row.paper_mre_percent),
               fmt::format("{:.3f}", row.off_grid_mre_percent), fmt::format("{:.3f}", row.off_grid_rel_l1_percent),
               format_count(row.false_values)});
  }
  table.print();
  for (const auto& [name, method] : kPaperMethodNames) {
    if (!has_method(rows, method)) continue;
    for (const std::uint64_t samples : kPaperCounts) {
      print(fmt::format("geometric mean of the ratios, {} at {} samples: {:.3f}\n", name, format_count(samples),
                        mean_ratio_to_paper(rows, method, samples)));
    }
  }
  print_orderings(rows);
  if (has_method(rows, PaperMethod::kRbf)) {
    print(fmt::format("rbf: kernel {}; the paper does not tell its own.\n", name_of(kRbfKernelNames, kernel)));
  }
  print("* the document's figures of Yellow satin and Red velvet carry each other's MRE; put right here.\n");
}

int run_accuracy(ReproduceOptions options) {
  for (const std::string& name : options.methods) {
    options.accuracy.methods.push_back(value_of(kPaperMethodNames, name).value_or(PaperMethod::kProposed));
  }
  options.accuracy.kernel = value_of(kRbfKernelNames, options.kernel).value_or(options.accuracy.kernel);
  if (Status free = check_csv(options); !free) return report_error(options.csv, free.error());
  options.accuracy.slices = chosen_slices(options);
  const Result<std::vector<AccuracyRow>> rows = [&] {
    ProgressBar bar("materials");
    return reproduce_accuracy(options.accuracy, bar.progress());
  }();
  if (!rows) return report_error("", rows.error());
  if (options.json) {
    print_json(accuracy_json(*rows));
  } else {
    print_accuracy(*rows, options.accuracy.kernel);
  }
  return write_csv(options, accuracy_csv(*rows));
}

std::string placement_name(std::size_t index) { return placement_text(table_3_placements()[index]); }

std::string placement_csv(const PlacementStudy& study) {
  std::string text = "samples,material,placement,mre_percent\n";
  for (const PlacementRow& row : study.rows) {
    for (std::size_t m = 0; m < study.materials.size(); ++m) {
      for (std::size_t p = 0; p < row.mre_percent[m].size(); ++p) {
        if (std::isnan(row.mre_percent[m][p])) continue;
        text +=
            fmt::format("{},{},{},{:.6g}\n", row.samples, study.materials[m], placement_name(p), row.mre_percent[m][p]);
      }
    }
  }
  return text;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Json placement_json(const PlacementStudy& study) {
  Json json = {{"rows", Json::array()}, {"increase", Json::array()}};
  for (const PlacementRow& row : study.rows) {
    Json without = Json::object();
    for (std::size_t m = 0; m < study.materials.size(); ++m)
      without[study.materials[m]] = placement_name(row.best_without[m]);
    json["rows"].push_back({{"samples", row.samples},
                            {"best", placement_name(row.best)},
                            {"table_3", placement_name(row.table_3)},
                            {"best_without", without}});
  }
  for (std::size_t m = 0; m < study.materials.size(); ++m) {
    json["increase"].push_back({{"material", study.materials[m]},
                                {"equation_1", study.increase[m]},
                                {"table_3", study.increase_table_3[m]},
                                {"paper", study.paper_increase[m]}});
  }
  json["mean_increase"] = {
      {"equation_1", mean(study.increase)}, {"table_3", mean(study.increase_table_3)}, {"paper", 1.20}};
  return json;
}

void print_placement(const PlacementStudy& study) {
  Table best;
  best.add({"samples", "Equation 1", "Table 3", "changes when left out"});
  for (const PlacementRow& row : study.rows) {
    std::string changes;
    for (std::size_t m = 0; m < study.materials.size(); ++m) {
      if (row.best_without[m] == row.best) continue;
      changes += (changes.empty() ? "" : ", ") + study.materials[m] + ": " + placement_name(row.best_without[m]);
    }
    best.add({format_count(row.samples), placement_name(row.best), placement_name(row.table_3),
              changes.empty() ? "-" : changes});
  }
  best.print();
  print("\nIncrease of the MRE over the best placement of each material, mean over the counts (Table 4):\n");
  Table increase;
  increase.add({"material", "Equation 1", "Table 3", "paper"});
  for (std::size_t m = 0; m < study.materials.size(); ++m) {
    increase.add({study.materials[m], fmt::format("{:.2f} x", study.increase[m]),
                  fmt::format("{:.2f} x", study.increase_table_3[m]),
                  fmt::format("{:.2f} x", study.paper_increase[m])});
  }
  increase.add({"mean", fmt::format("{:.2f} x", mean(study.increase)),
                fmt::format("{:.2f} x", mean(study.increase_table_3)), "1.20 x"});
  increase.print();
}

constexpr double kMegabyte = 1U << 20U;  // as in Table 5

Json storage_json(const std::vector<TextureSizes>& rows) {
  Json json = Json::array();
  for (const TextureSizes& row : rows) {
    Json files = Json::array();
    for (const TextureSizes::File& file : row.files)
      files.push_back({{"name", file.name}, {"bytes", file.bytes.size()}});
    json.push_back({{"method", row.method},
                    {"structure", row.structure},
                    {"samples", row.samples},
                    {"paper_megabytes", row.paper_megabytes ? Json(*row.paper_megabytes) : Json()},
                    {"megabytes", static_cast<double>(row.texel_bytes) / kMegabyte},
                    {"formula_bytes", row.formula_bytes ? Json(*row.formula_bytes) : Json()},
                    {"texel_bytes", row.texel_bytes},
                    {"file_bytes", row.file_bytes()},
                    {"files", files},
                    {"mre_percent", row.of_source.mre_percent},
                    {"rel_l1_percent", row.of_source.rel_l1_percent}});
  }
  return json;
}

void print_storage(const std::vector<TextureSizes>& rows) {
  Table table;
  table.add({"method", "samples", "paper [MB]", "here [MB]", "formula", "texels", "files", "MRE [%]", "rel. L1 [%]"});
  for (const TextureSizes& row : rows) {
    table.add({row.method + ", " + row.structure, format_count(row.samples),
               row.paper_megabytes ? fmt::format("{:.1f}", *row.paper_megabytes) : "-",
               fmt::format("{:.1f}", static_cast<double>(row.texel_bytes) / kMegabyte),
               row.formula_bytes ? format_count(*row.formula_bytes) : "-", format_count(row.texel_bytes),
               format_count(row.file_bytes()), fmt::format("{:.2f}", row.of_source.mre_percent),
               fmt::format("{:.2f}", row.of_source.rel_l1_percent)});
  }
  table.print();
  print(
      "MB: 2^20 bytes. formula, texels, files: bytes; files are compressed where their kind is. Errors are against the "
      "material,\non directions that are dense in highlights. The paper does not tell how it looks up barycentric "
      "weights: cube maps of\n256 x 256 faces with three numbers of 8 bits and three half floats are an assumption "
      "that "
      "fits both of its figures.\n");
}

int write_files(const std::vector<TextureSizes>& rows, const std::string& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return report_error(folder, io_error(failed.message()));
  for (const TextureSizes& row : rows) {
    for (const TextureSizes::File& file : row.files) {
      const std::string path = (std::filesystem::path(folder) / file.name).string();
      if (Status put = write_file_atomically(path, file.bytes); !put) return report_error(path, put.error());
    }
  }
  return 0;
}

int run_storage(const ReproduceOptions& options) {
  const Result<std::vector<TextureSizes>> rows = [&] {
    ProgressBar bar("textures");
    return reproduce_storage(options.material, bar.progress());
  }();
  if (!rows) return report_error(options.material, rows.error());
  if (!options.folder.empty()) {
    if (const int failed = write_files(*rows, options.folder); failed != 0) return failed;
  }
  if (options.json) {
    print_json(storage_json(*rows));
  } else {
    print_storage(*rows);
  }
  return 0;
}

// From the crossings of the sparsest placement to the densest uniform scheme of the paper.
std::vector<std::uint64_t> default_counts() {
  std::vector<std::uint64_t> counts;
  constexpr int kSteps = 20;
  for (int k = 0; k <= kSteps; ++k) {
    counts.push_back(
        static_cast<std::uint64_t>(std::llround(60 * std::pow(354061.0 / 60, static_cast<double>(k) / kSteps))));
  }
  return counts;
}

std::vector<std::uint64_t> parse_counts(const std::string& text) {
  std::vector<std::uint64_t> counts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const auto count = parse_count(text.substr(begin, comma - begin));
    if (!count || *count < 55 || *count > kMaxSampleCount || (!counts.empty() && *count <= counts.back())) {
      throw CLI::ValidationError("--counts",
                                 "'" + text + "' is not a rising list of counts from 55 to 1,000,000 such as 500,5000");
    }
    counts.push_back(*count);
    begin = comma + 1;
  }
  return counts;
}

int run_placement(ReproduceOptions options) {
  if (Status free = check_csv(options); !free) return report_error(options.csv, free.error());
  options.placement.slices = chosen_slices(options);
  options.placement.counts = options.counts.empty() ? default_counts() : parse_counts(options.counts);
  const Result<PlacementStudy> study = [&] {
    ProgressBar bar("placements");
    return reproduce_placement(options.placement, bar.progress());
  }();
  if (!study) return report_error("", study.error());
  if (options.json) {
    print_json(placement_json(*study));
  } else {
    print_placement(*study);
  }
  return write_csv(options, placement_csv(*study));
}

template <class T, std::size_t N>
CLI::IsMember one_of(const std::array<Named<T>, N>& table) {
  const auto names = names_of(table);
  return CLI::IsMember(std::vector<std::string>(names.begin(), names.end()));
}

void add_common(CLI::App& command, ReproduceOptions& options) {
  command.add_option("--domain", options.domain, "Interpolate the values, as the paper does, or their logarithms")
      ->check(one_of(kDomainNames))
      ->capture_default_str();
  command.add_option("--refine", options.refine, "Place samples as the paper does, or by the true error")
      ->check(one_of(kRefinementNames))
      ->capture_default_str();
  command.add_option("--csv", options.csv, "Also write the figures to this file")->type_name("FILE");
  command.add_flag("--json", options.json, "Print JSON");
}

void add_accuracy(CLI::App& reproduce, const std::shared_ptr<ReproduceOptions>& options, int& exit_code) {
  auto* command = reproduce.add_subcommand(
      "accuracy", "The MRE of ten materials at 8,911 and 18,721 samples, of the paper's three methods.");
  add_common(*command, *options);
  command->add_option("--method", options->methods, "Only this of the three methods; may be repeated")
      ->check(one_of(kPaperMethodNames))
      ->allow_extra_args(false);
  command
      ->add_option("--rbf-kernel", options->kernel,
                   "What radial basis functions make of a chord r: r, r^3, r^2 log r, 1 / sqrt(r^2 + 0.09)")
      ->check(one_of(kRbfKernelNames))
      ->capture_default_str();
  command->add_option("--material", options->accuracy.materials, "Only this material of the ten; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_count(*command, "--random", options->accuracy.random_count, {1, 1'000'000'000},
            "So many random pairs of the 2-degree grid instead of all 54,464,400, and as many off it (else 1,000,000)")
      ->default_str("");
  add_count(*command, "--seed", options->accuracy.seed, {}, "Of the random pairs");
  command->add_flag("--auto", options->accuracy.automatic,
                    "Frame, domain, nodes and guide by search, samples by true error");
  command->footer("Example:\n  sbrdf reproduce accuracy --random 100000 --csv accuracy.csv");
  command->callback([options, &exit_code] { exit_code = run_accuracy(*options); });
}

void add_placement(CLI::App& reproduce, const std::shared_ptr<ReproduceOptions>& options, int& exit_code) {
  auto* command = reproduce.add_subcommand("placement", "Section 6: the best placement for each number of samples.");
  add_common(*command, *options);
  command->add_option("--counts", options->counts, "Numbers of samples (default: 21 from 60 to 354,061)")
      ->type_name("N,N,...");
  add_count(*command, "--random", options->placement.random_count, {1, 1'000'000},
            "Random pairs of the 2-degree grid that errors are measured on");
  add_count(*command, "--seed", options->placement.seed, {}, "Of the random pairs");
  command->footer("Example:\n  sbrdf reproduce placement --counts 1000,10000 --random 2000");
  command->callback([options, &exit_code] { exit_code = run_placement(*options); });
}

void add_storage(CLI::App& reproduce, const std::shared_ptr<ReproduceOptions>& options, int& exit_code) {
  auto* command = reproduce.add_subcommand("storage", "Table 5: bytes on a graphics card, of textures that are made.");
  command->add_option("--material", options->material, "One of the ten materials")->capture_default_str();
  command->add_option("--out", options->folder, "Write the textures into this folder, made if it is not there")
      ->type_name("FOLDER");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  sbrdf reproduce storage --out textures");
  command->callback([options, &exit_code] { exit_code = run_storage(*options); });
}

}  // namespace

void add_reproduce(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("reproduce", "Makes the tables of the paper again.");
  command->require_subcommand(1);
  const auto options = std::make_shared<ReproduceOptions>();
  command->footer("Example:\n  sbrdf reproduce accuracy --random 100000");
  add_accuracy(*command, options, exit_code);
  add_placement(*command, options, exit_code);
  add_storage(*command, options, exit_code);
}

}  // namespace sbrdf::internal
