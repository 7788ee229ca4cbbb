#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/file/reader.h"
#include "codec/material/cut.h"
#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/slicing/metadata.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

struct ExtractOptions {
  std::string in;
  std::string out;
  double theta_max_deg = 90;
  std::uint64_t level = kMaxDepth;
  MemoryLimit memory;
  bool json = false;
};

struct Extraction {
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_read = 0;
  std::size_t samples_in = 0;
  std::size_t samples_out = 0;
  double theta_max_deg = 90;     ///< of the part
  std::vector<std::byte> bytes;  ///< of the file to write
  Comparison difference;         ///< from the whole, over random directions below the new theta_max
};

Result<Comparison> difference_from_whole(const DecodedSliced& whole, const SlicedBrdf& cut, double theta_max_deg) {
  CompareOptions options;
  options.theta_max_deg = theta_max_deg;
  options.step_deg = std::max(0.1, theta_max_deg / 40);
  options.random_count = 20'000;
  options.false_values = FalseValueSearch::kNone;
  const SlicedSource reference(whole);
  const SlicedSource test({cut, build_lattice(cut.frame).value()});
  return compare_sources(reference, test, options);
}

Result<Extraction> extract(const ExtractOptions& options) {
  const Result<std::shared_ptr<const ByteSource>> file =
      open_sliced_bytes(options.in, "parts and levels", options.memory);
  if (!file) return file.error();
  Extraction done;
  done.bytes_in = (*file)->size();
  const CallbackSource counted(done.bytes_in, [&](std::uint64_t offset, std::span<std::byte> target) {
    done.bytes_read += target.size();
    return (*file)->read(offset, target);
  });
  const Result<SlicedReader> reader = SlicedReader::open(counted, options.memory);
  if (!reader) return reader.error();
  const DirectionBox box = {.theta_to = options.theta_max_deg};
  const Result<PartialSliced> part =
      reader->load(cells_in(reader->lattice(), box, box), static_cast<int>(options.level));
  if (!part) return part.error();
  Result<std::string> metadata = reader->metadata();
  if (!metadata) return metadata.error();
  Result<std::shared_ptr<const DirectionMask>> mask = reader->mask();
  if (!mask) return mask.error();
  const std::uint64_t needed = done.bytes_read;
  Result<SlicedBrdf> cut =
      cut_sliced(part->sliced(), reader->lattice(), {options.theta_max_deg, static_cast<int>(options.level)});
  if (!cut) return cut.error();
  cut->mask = *std::move(mask);
  Result<SlicedBrdf> whole = reader->load_all();
  if (!whole) return whole.error();
  const double theta_max = std::min(options.theta_max_deg, cut->frame.theta_max_deg);
  const Result<Comparison> difference = difference_from_whole({*std::move(whole), reader->lattice()}, *cut, theta_max);
  if (!difference) return difference.error();
  done.difference = *difference;
  done.bytes_read = needed;
  cut->metadata = metadata_of_part(*metadata, {options.theta_max_deg, options.level, difference->rel_l1_percent});
  done.samples_in = reader->lattice().crossings.size() + reader->index().adaptive_count + reader->index().guide_count;
  done.samples_out = cut->sample_count();
  done.theta_max_deg = theta_max;
  std::vector<std::byte> bytes =
      encode_sliced(*cut, build_lattice(cut->frame).value(), {reader->index().scale.bound()});
  done.bytes = std::move(bytes);
  return done;
}

int run_extract(const ExtractOptions& options) {
  const Result<const Format*> writer = find_writer(std::filesystem::path(options.out).extension().string());
  if (!writer || !(*writer)->capabilities.has(Capability::kParts)) {
    return report_error(options.out, usage_error("a part is a sliced file: the name must end with .sbrdf"));
  }
  if (Status free = check_output(options.out, *writer, std::span(&options.in, 1)); !free) {
    return report_error(options.out, free.error());
  }
  const Result<Extraction> done = extract(options);
  if (!done) return report_error(options.in, done.error());
  if (Status written = write_file_atomically(options.out, done->bytes); !written) {
    return report_error(options.out, written.error());
  }
  if (options.json) {
    print_json({{"in", options.in},
                {"bytes_in", done->bytes_in},
                {"bytes_read", done->bytes_read},
                {"samples_in", done->samples_in},
                {"out", options.out},
                {"bytes_out", done->bytes.size()},
                {"samples_out", done->samples_out},
                {"theta_max_deg", done->theta_max_deg},
                {"difference_mre_percent", done->difference.mre_percent},
                {"difference_rel_l1_percent", done->difference.rel_l1_percent}});
    return 0;
  }
  Table table;
  table.add({"read", options.in + ": " + format_count(done->samples_in) + " samples, " + format_count(done->bytes_in) +
                         " bytes, of which the part needed " + format_count(done->bytes_read)});
  table.add({"wrote", options.out + ": " + format_count(done->samples_out) + " samples, " +
                          format_count(done->bytes.size()) + " bytes"});
  table.add({"", "directions up to theta_max = " + format_number(done->theta_max_deg) +
                     " degrees; beyond, it gives the value held at theta_max"});
  table.add({"", "difference from the whole in the directions that are left: relative L1 " +
                     format_number(done->difference.rel_l1_percent) + " %, MRE " +
                     format_number(done->difference.mre_percent) + " %, over 20,000 random directions"});
  table.print();
  return 0;
}

}  // namespace

void add_extract(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("extract", "Writes a smaller sliced file: fewer directions, coarser levels.");
  const auto options = std::make_shared<ExtractOptions>();
  command->add_option("IN", options->in, "A sliced file, or BUNDLE.sbrdfz:NAME")->required();
  command->add_option("OUT", options->out, "The sliced file to write")->required();
  add_number(*command, "--theta-max", options->theta_max_deg, {1, 90}, "DEG",
             "Both directions below this, in degrees; the file goes on to the next node");
  add_count(*command, "--level", options->level, {0, kMaxDepth},
            "Samples up to this level of refinement: 0 crossings only, 1 the middles between them, ...");
  command->add_flag("--json", options->json, "Print JSON");
  add_memory_limit(*command, options->memory);
  command->footer(
      "The precision stays that of IN. Values differ a little from IN's, most near the largest theta, because slices "
      "end there: the report says how much.\n\nExample:\n  sbrdf extract material.sbrdf part.sbrdf --theta-max 60 "
      "--level 3");
  command->callback([options, &exit_code] { exit_code = run_extract(*options); });
}

}  // namespace sbrdf::internal
