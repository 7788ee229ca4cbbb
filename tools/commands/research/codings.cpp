#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/audit/codings.h"
#include "converters/slicing/slicing.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/columns.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

struct CodingsOptions {
  std::vector<std::string> sources;
  std::uint64_t samples = kDefaultSampleCount;
  std::string placement;
  std::string csv;
  MemoryLimit memory;
  bool json = false;
};

Result<CodingSizes> sizes_of(const std::string& name, const CodingsOptions& options) {
  const Result<OpenedSource> opened = open_source(name, within(options.memory));
  if (!opened) return opened.error();
  if (const DecodedSliced* content = opened->source->sliced()) {
    return coding_sizes(name, content->sliced, content->lattice);
  }
  SliceOptions slices;
  slices.stop = SampleCount{options.samples};
  slices.precision = 0;
  if (options.placement == "paper") slices.structure = table_3_placement(options.samples);
  ProgressBar bar(name);
  const Result<Slicing> slicing = slice_source(*opened->source, slices, bar.progress());
  if (!slicing) return slicing.error();
  return coding_sizes(name, slicing->sliced, slicing->lattice);
}

nlohmann::ordered_json as_json(const CodingSizes& row) {
  return {{"material", row.material},
          {"samples", row.samples},
          {"values", row.values},
          {"raw_bytes", row.raw},
          {"lossless_bytes", row.lossless},
          {"tenth_percent_bytes", row.tenth_percent},
          {"one_percent_bytes", row.one_percent},
          {"bits_per_value", row.bits_per_value()},
          {"baseline_bytes", row.baseline},
          {"baseline_ratio", static_cast<double>(row.baseline) / static_cast<double>(row.tenth_percent)},
          {"stream_bytes", row.stream},
          {"entropy_bytes", row.entropy}};
}

// The last row of the table.
CodingSizes mean_of(const std::vector<CodingSizes>& rows) {
  CodingSizes mean;
  mean.material = "mean";
  const auto average = [&](auto CodingSizes::*member) {
    double sum = 0;
    for (const CodingSizes& row : rows) sum += static_cast<double>(row.*member);
    mean.*member = static_cast<std::remove_reference_t<decltype(mean.*member)>>(
        std::llround(sum / static_cast<double>(rows.size())));
  };
  for (auto member :
       {&CodingSizes::samples, &CodingSizes::values, &CodingSizes::raw, &CodingSizes::lossless,
        &CodingSizes::tenth_percent, &CodingSizes::one_percent, &CodingSizes::baseline, &CodingSizes::stream}) {
    average(member);
  }
  average(&CodingSizes::entropy);
  return mean;
}

void print_as_table(std::vector<CodingSizes> rows) {
  if (rows.size() > 1) rows.push_back(mean_of(rows));
  Table table;
  table.add(
      {"material", "samples", "raw", "lossless", "0.1 %", "1 %", "bits/value", "baseline", "ratio", "entropy left"});
  for (const CodingSizes& row : rows) {
    table.add({row.material, format_count(row.samples), format_count(row.raw), format_count(row.lossless),
               format_count(row.tenth_percent), format_count(row.one_percent),
               fmt::format("{:.2f}", row.bits_per_value()), format_count(row.baseline),
               fmt::format("{:.2f} x", static_cast<double>(row.baseline) / static_cast<double>(row.tenth_percent)),
               fmt::format("{:.1f} %", 100 * (1 - row.entropy / static_cast<double>(row.stream)))});
  }
  table.print();
  print(
      "Bytes. raw: float32 values and positions. lossless, 0.1 %, 1 %: .sbrdf files with everything in them. "
      "bits/value,\n"
      "baseline (logarithms quantised, differences, bytes shuffled, zstd -3), ratio: at 0.1 %. entropy left: what "
      "ideal\n"
      "coding of the same residuals in the same contexts would save of the coded samples.\n");
}

int run_codings(const CodingsOptions& options) {
  if (!options.csv.empty()) {
    if (Status free = check_output(options.csv, nullptr, options.sources); !free) {
      return report_error(options.csv, free.error());
    }
  }
  std::vector<CodingSizes> rows;
  std::string csv = "material,samples,values,raw,lossless,tenth_percent,one_percent,baseline,stream,entropy\n";
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const std::string& name : options.sources) {
    const Result<CodingSizes> row = sizes_of(name, options);
    if (!row) return report_error(name, row.error());
    rows.push_back(*row);
    json.push_back(as_json(*row));
    csv +=
        fmt::format("{},{},{},{},{},{},{},{},{},{:.0f}\n", csv_cell(row->material), row->samples, row->values, row->raw,
                    row->lossless, row->tenth_percent, row->one_percent, row->baseline, row->stream, row->entropy);
  }
  if (options.json) {
    print_json(json);
  } else {
    print_as_table(rows);
  }
  if (options.csv.empty()) return 0;
  const Status written = write_file_atomically(options.csv, std::as_bytes(std::span(csv.data(), csv.size())));
  return written ? 0 : report_error(options.csv, written.error());
}

}  // namespace

void add_codings(CLI::App& program, int& exit_code) {
  auto* command =
      program.add_subcommand("codings", "How many bytes the samples of materials take, one way and another.");
  const auto options = std::make_shared<CodingsOptions>();
  command->add_option("SOURCE", options->sources, "Sliced files as they are; anything else is sliced first")
      ->required();
  add_count(*command, "--samples", options->samples, {1, kMaxSampleCount}, "For sources that are not sliced");
  command
      ->add_option("--placement", options->placement,
                   "paper: slices where the paper's Table 3 puts them, instead of by search")
      ->check(CLI::IsMember({"paper"}))
      ->type_name("paper");
  command->add_option("--csv", options->csv, "Also write the figures to this file")->type_name("FILE");
  command->add_flag("--json", options->json, "Print JSON");
  add_memory_limit(*command, options->memory);
  command->footer("Example:\n  sbrdf codings kurt:fabric112 kurt:wood01 --samples 8911");
  command->callback([options, &exit_code] { exit_code = run_codings(*options); });
}

}  // namespace sbrdf::internal
