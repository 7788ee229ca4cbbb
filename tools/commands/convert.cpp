#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "converters/files/format_table.h"
#include "converters/slicing/slicing.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/files.h"
#include "tools/io/sources.h"

namespace sbrdf {
namespace {

constexpr std::uint64_t kMostBytes = 1'000'000'000;
constexpr Range kTarget = {0, 1000, true};  // [%]

struct ConvertOptions {
  std::string in;
  std::string out;
  SliceOptions slices;
  std::uint64_t samples = kDefaultSampleCount;
  std::optional<double> target_mre_percent;
  std::optional<double> target_rel_l1_percent;
  std::optional<std::uint64_t> max_bytes;
  std::size_t evaluations = kDefaultSearchEvaluations;
  std::string frame = "auto";
  std::string domain = "auto";
  std::string placement = "auto";
  std::string refine = "true";
  bool no_mirrors = false;
  std::optional<std::string> precision;  ///< as given; otherwise 0.1 %, or that of a sliced source
  std::string chunks = "auto";
  bool slicing_given = false;      ///< any of the options that only sliced files have
  bool evaluations_given = false;  ///< --search-evaluations
  bool json = false;
};

struct Conversion {
  OpenedSource in;
  const Format* format = nullptr;
  SavedFile out;
  double seconds = 0;
};

/// An error and whose it is.
struct Failure {
  std::string subject;
  Error error;
};

Placement parse_steps(const std::string& text) {
  const auto slash = text.find('/');
  const auto elevation = parse_number(text.substr(0, slash));
  const auto azimuth = slash == std::string::npos ? std::nullopt : parse_number(text.substr(slash + 1));
  if (!elevation || !azimuth || *elevation <= 0 || *azimuth <= 0) {
    throw CLI::ValidationError(
        "--placement",
        "'" + text + "' is neither auto, search, paper, nor two positive numbers of degrees such as 14/36");
  }
  return {*elevation, *azimuth};
}

EncodeOptions encoding_of(const ConvertOptions& options) {
  EncodeOptions encoding = SliceOptions{}.encoding;
  encoding.chunks = options.chunks == "whole"   ? ChunkSize::kWhole
                    : options.chunks == "split" ? ChunkSize::kSplit
                                                : ChunkSize::kAuto;
  if (options.precision == "lossless") {
    encoding.precision = 0;
  } else if (options.precision) {
    const std::string& text = *options.precision;
    const auto percent = parse_number(std::string_view(text).substr(0, text.size() - (text.ends_with('%') ? 1 : 0)));
    if (!percent || !(*percent >= 1e-4 && *percent <= 50)) {
      throw CLI::ValidationError("--precision",
                                 "'" + text + "' is neither lossless nor 0.0001 to 50 percent, such as 0.1%");
    }
    encoding.precision = *percent / 100;
  }
  return encoding;
}

// An option without effect is a misunderstanding. Those that exclude each other whatever their values: see
// add_slicing_options.
void refuse_contradictions(const ConvertOptions& options) {
  const bool given = options.placement != "auto" && options.placement != "search";
  if (given && options.frame == "half-difference") {
    throw CLI::ValidationError(
        "--placement", "'" + options.placement + "' is one of the elevation frame, not of --frame half-difference");
  }
  if (!options.evaluations_given) return;
  if (given) {
    throw CLI::ValidationError("--search-evaluations", "nothing is searched for with --placement " + options.placement);
  }
  if (options.placement == "auto" && options.frame == "elevation") {
    throw CLI::ValidationError(
        "--search-evaluations",
        "nothing is searched for with --frame elevation unless --placement search is given, too");
  }
}

StopRule stop_rule(const ConvertOptions& options) {
  if (options.target_mre_percent) return TargetMre{*options.target_mre_percent};
  if (options.target_rel_l1_percent) return TargetRelL1{*options.target_rel_l1_percent};
  if (options.max_bytes) return MaxBytes{*options.max_bytes};
  return SampleCount{options.samples};
}

// With the elevation frame asked for by name, "auto" is the paper's own rule, too.
StructureRule structure_rule(const ConvertOptions& options) {
  if (options.placement == "paper" || (options.placement == "auto" && options.frame == "elevation")) {
    return table_3_placement(options.samples);
  }
  if (options.placement != "auto" && options.placement != "search") return parse_steps(options.placement);
  SearchedStructure search;
  if (options.frame == "elevation") search.frame = FrameId::kElevation;
  if (options.frame == "half-difference") search.frame = FrameId::kHalfDifference;
  search.use_mirrors = !options.no_mirrors;
  search.evaluations = options.evaluations;
  return search;
}

void settle_choices(ConvertOptions& options) {
  SliceOptions& slices = options.slices;
  slices.stop = stop_rule(options);
  slices.structure = structure_rule(options);
  if (options.domain == "linear") slices.domain = DomainKind::kLinear;
  if (options.domain == "log") slices.domain = DomainKind::kLog;
  slices.refinement = options.refine == "measured" ? Refinement::kByMeasured : Refinement::kBySource;
  slices.encoding = encoding_of(options);
}

bool is_sliced(const Format& format) { return format.name == "sbrdf"; }

std::optional<Failure> convert(const ConvertOptions& options, Conversion& done) {
  const Stopwatch watch;
  const Result<const Format*> writer = find_writer(std::filesystem::path(options.out).extension().string());
  if (!writer) return Failure{options.out, writer.error()};
  done.format = *writer;
  const bool encoding_given = options.precision || options.chunks != "auto";
  if ((options.slicing_given || encoding_given) && !is_sliced(*done.format)) {
    return Failure{options.out, usage_error("the options on slices need a .sbrdf file to be written")};
  }
  if (Status free = check_destination(options.out); !free) return Failure{options.out, free.error()};
  Result<OpenedSource> in = open_source(options.in);
  if (!in) return Failure{options.in, in.error()};
  done.in = *std::move(in);

  SaveOptions save;
  if (options.slicing_given || done.in.source->traits().format != "sbrdf") {
    save.slices = options.slices;
    if (is_sliced(*done.format)) save.slices->source_sha256 = sha256_of(options.in);
  }
  if (options.precision) save.copy_precision = options.slices.encoding.precision;
  save.copy_chunks = options.slices.encoding.chunks;
  ProgressBar bar("converting");
  Result<SavedFile> saved = done.format->save(*done.in.source, save, bar.progress());
  if (!saved) return Failure{options.in, saved.error()};
  done.out = *std::move(saved);
  if (Status written = write_file_atomically(options.out, done.out.bytes); !written) {
    return Failure{options.out, written.error()};
  }
  done.seconds = watch.seconds();
  return std::nullopt;
}

// What was asked for, for the metadata: names of files without their folders, which say more about a machine than about
// a material.
std::string command_text(const CLI::App& command, const ConvertOptions& options) {
  const auto name_of = [](const std::string& path) {
    return path.starts_with(kKurtPrefix) && path.find('/') == std::string::npos
               ? path
               : std::filesystem::path(path).filename().string();
  };
  std::string text = "sbrdf convert " + name_of(options.in) + " " + name_of(options.out);
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_positional() || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (name == "json") continue;
    text += " --" + name;
    if (option->get_items_expected_max() > 0) text += " " + option->results().back();
  }
  return text;
}

void print_as_json(const ConvertOptions& options, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  nlohmann::ordered_json json;
  json["in"] = {{"path", options.in}, {"format", traits.format}, {"description", traits.description}};
  json["in"]["bytes"] = done.in.bytes ? nlohmann::ordered_json(*done.in.bytes) : nlohmann::ordered_json();
  json["in"]["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : traits.findings) {
    json["in"]["findings"].push_back({{"what", finding.what}, {"count", finding.count}, {"total", finding.total}});
  }
  json["out"] = {{"path", options.out}, {"format", done.format->name}, {"bytes", done.out.bytes.size()}};
  json["remarks"] = nlohmann::ordered_json::array();
  for (const Remark& remark : done.out.remarks) {
    json["remarks"].push_back({{"key", remark.key}, {"value", remark.value}, {"text", remark.text}});
  }
  json["seconds"] = done.seconds;
  print_json(json);
}

void print_as_table(const ConvertOptions& options, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  Table table;
  table.add({"read", options.in + ": " + traits.description +
                         (done.in.bytes ? ", " + format_count(*done.in.bytes) + " bytes" : "")});
  for (const Finding& finding : traits.findings) {
    table.add({"found", format_count(finding.count) + " of " + format_count(finding.total) + " " + finding.what});
  }
  table.add({"wrote", options.out + ": " + std::string(done.format->description) + ", " +
                          format_count(done.out.bytes.size()) + " bytes"});
  for (const Remark& remark : done.out.remarks) table.add({"", remark.text});
  table.add({"took", format_number(done.seconds) + " s"});
  table.print();
}

int run_convert(const ConvertOptions& options) {
  Conversion done;
  if (const auto failure = convert(options, done)) return report_error(failure->subject, failure->error);
  if (options.json) {
    print_as_json(options, done);
  } else {
    print_as_table(options, done);
  }
  return 0;
}

void add_slicing_options(CLI::App& command, ConvertOptions& options) {
  SliceOptions& slices = options.slices;
  const auto mark = [&options](CLI::Option* option) {
    return option->group("For .sbrdf files")->each([&options](const std::string&) { options.slicing_given = true; });
  };
  const auto choice = [&](const char* flag, std::string& value, const std::vector<std::string>& names,
                          const char* help) {
    mark(command.add_option(flag, value, help)->check(CLI::IsMember(names))->type_name("NAME")->capture_default_str());
  };
  auto* samples = mark(
      add_count(command, "--samples", options.samples, {1, kMaxSampleCount}, "Directions sampled, crossings included"));
  auto* mre = mark(add_number(command, "--target-mre", options.target_mre_percent, kTarget, "PERCENT",
                              "Instead of --samples: as few as reach this mean relative error"));
  auto* rel_l1 = mark(add_number(command, "--target-rel-l1", options.target_rel_l1_percent, kTarget, "PERCENT",
                                 "Instead of --samples: as few as reach this relative L1 error"));
  auto* bytes = mark(add_count(command, "--max-bytes", options.max_bytes, {1, kMostBytes},
                               "Instead of --samples: as many as fit a file of this size"));
  samples->excludes(mre, rel_l1, bytes);
  mre->excludes(rel_l1, bytes);
  rel_l1->excludes(bytes);
  choice("--frame", options.frame, {"auto", "elevation", "half-difference"}, "Coordinates of the slices");
  choice("--domain", options.domain, {"auto", "linear", "log"}, "Interpolate the values or their logarithms");
  mark(
      command
          .add_option("--placement", options.placement,
                      "Degrees between elevations and between azimuths of the slices in the elevation frame; paper: by "
                      "the paper's Table 3 from the number of samples; search: nodes by the error on held-back "
                      "directions; auto: paper if --frame elevation was given, else search")
          ->type_name("auto|search|paper|E/A")
          ->capture_default_str());
  choice("--refine", options.refine, {"true", "measured"},
         "Place samples by the true error against the source, or as a goniometer must, by what was measured already");
  mark(add_number(command, "--minimum-gap", slices.minimum_gap_deg, {0.01, 90}, "DEG",
                  "Samples are not set closer than this, in degrees; 0.1, or 1 with --refine measured"));
  mark(add_count(
           command, "--search-evaluations", options.evaluations, {1, 100'000},
           "Structures a search tries for N, N / 2, N / 4 ... samples each; the round of some fifty in which it gets "
           "there is finished"))
      ->each([&options](const std::string&) { options.evaluations_given = true; });
  mark(command.add_flag("--no-mirrors", options.no_mirrors,
                        "Do not use mirror symmetries of the source; a placement by steps never does"));
  command
      .add_option("--precision", options.precision,
                  "Largest relative error of every stored sample, in percent, or lossless [0.1%, or as in a sliced IN]")
      ->type_name("lossless|P%")
      ->group("For .sbrdf files");
  command
      .add_option(
          "--chunks", options.chunks,
          "whole: the smallest file; split: a region can be loaded by itself; auto: split from 65,536 samples on")
      ->check(CLI::IsMember({"auto", "whole", "split"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group("For .sbrdf files");
}

}  // namespace

void add_convert(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("convert", "Writes a BRDF in another format.");
  const auto options = std::make_shared<ConvertOptions>();
  command->add_option("IN", options->in, "A file of any readable format, kurt:NAME or kurt:FILE.json")->required();
  command->add_option("OUT", options->out, "The file to write; its extension chooses the format")->required();
  add_slicing_options(*command, *options);
  command->add_flag("--json", options->json, "Print the report as JSON");
  command->footer(
      "A sliced IN is copied to a sliced OUT as it is, unless one of the options on slices asks to sample it again;\n"
      "--precision and --chunks only write it another way.\n\n"
      "Examples:\n"
      "  sbrdf convert material.bsdf material.sbrdf --samples 4096\n"
      "  sbrdf convert material.sbrdf material.binary\n"
      "  sbrdf convert kurt:fabric112 fabric112.sbrdf --samples 8911 --placement 14/36 --domain linear --refine "
      "measured");
  command->callback([options, command, &exit_code] {
    refuse_contradictions(*options);
    settle_choices(*options);
    options->slices.command = command_text(*command, *options);
    exit_code = run_convert(*options);
  });
}

}  // namespace sbrdf
