#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/by_name.h"
#include "formats/core/numbers.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/terminal.h"
#include "tools/io/direction_rows.h"
#include "tools/io/line_reader.h"

namespace sbrdf::internal {
namespace {

struct EvalOptions {
  std::string file;
  bool cosine = false;
  bool filled = false;  ///< say what is filled in where nothing was measured
  Options given;        ///< of reading the file
  bool json = false;
};

constexpr std::size_t kMostInName = 60;  // characters of a channel's
const char* const kInputName = "standard input";

/// From standard input to standard output, a block of lines at a time.
class Evaluation {
 public:
  Evaluation(const BrdfSource& source, const EvalOptions& options) : source_(source), options_(options) {
    for (const std::string& name : source.traits().channels) channels_.push_back(one_line(name, kMostInName));
  }

  Status run() {
    while (true) {
      const Result<std::vector<std::string_view>> lines = reader_.next();
      if (!lines) return at_line(lines.error(), line_number_ + 1);
      if (lines->empty()) break;
      // Rows before a bad one are answered.
      Status parsed = parse(*lines);
      write_rows();
      if (!parsed) return parsed;
      if (!flush_output()) return ok_status();
    }
    if (!header_) return invalid_file("empty: a header theta_i,phi_i,theta_v,phi_v is needed");
    if (options_.json) print(row_written_ ? "\n]\n" : "[]\n");
    note_beyond();
    note_unmeasured();
    return ok_status();
  }

 private:
  // What a value that nobody measured looks like: any other.
  void note_beyond() const {
    if (beyond_ == 0) return;
    const SourceTraits& traits = source_.traits();
    print_note(options_.file, fmt::format("{} of {} pairs have a direction beyond theta_max = {:g} degrees: {}",
                                          beyond_, answered_, traits.theta_max_deg, traits.beyond_theta_max));
  }

  void note_unmeasured() const {
    if (unmeasured_ == 0) return;
    print_note(options_.file, fmt::format("{} of {} pairs were not measured: {}", unmeasured_, answered_,
                                          options_.filled ? "their values are filled in"
                                          : options_.json ? "null"
                                                          : "nan"));
  }

  static Error at_line(const Error& error, std::uint64_t line) {
    if (error.code != ErrorCode::kInvalidFile) return error;
    return {error.code, fmt::format("line {}: {}", line, error.message), {}};
  }

  Status parse(const std::vector<std::string_view>& lines) {
    rows_.clear();
    for (const std::string_view line : lines) {
      ++line_number_;
      if (!header_) {
        if (Status begun = begin(line); !begun) return at_line(begun.error(), line_number_);
        continue;
      }
      const bool blank = line.find_first_not_of(" \t\r\n") == std::string_view::npos;
      if (blank) {
        if (!blank_line_) blank_line_ = line_number_;
        continue;
      }
      if (blank_line_) return at_line(invalid_file("empty, but rows follow"), *blank_line_);
      Result<DirectionRow> row = parse_direction_row(line, column_count_);
      if (!row) return at_line(row.error(), line_number_);
      rows_.push_back(*std::move(row));
    }
    return ok_status();
  }

  Status begin(std::string_view line) {
    Result<DirectionHeader> header = parse_direction_header(line);
    if (!header) return header.error();
    std::vector<std::string>& names = header->names;
    // What an earlier run appended is worked out anew: the output can be the input.
    const bool again =
        names.size() >= 4 + channels_.size() && std::equal(channels_.rbegin(), channels_.rend(), names.rbegin());
    column_count_ = names.size();
    names.resize(names.size() - (again ? channels_.size() : 0));
    kept_count_ = names.size();
    names.insert(names.end(), channels_.begin(), channels_.end());
    if (Status unique = check_unique(names); !unique) return unique.error();
    if (!options_.json) print(output_header(header->text));
    header_ = *std::move(header);
    return ok_status();
  }

  static Status check_unique(std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    const auto twice = std::adjacent_find(names.begin(), names.end());
    if (twice == names.end()) return ok_status();
    return invalid_file("there would be two columns with the name '" + one_line(*twice, 60) + "'");
  }

  /// Of a line, the columns of the input that are kept.
  [[nodiscard]] std::string_view kept(std::string_view line) const {
    return kept_count_ == column_count_ ? line : line.substr(0, size_of_fields(line, kept_count_));
  }

  [[nodiscard]] std::string output_header(std::string_view input) const {
    std::string line(kept(input));
    for (const std::string& channel : channels_) line += "," + csv_field(channel);
    return line + "\n";
  }

  void write_rows() {
    const std::vector<double> values = evaluate();
    const std::size_t channels = source_.channel_count();
    std::string text;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const std::span<const double> of_row(values.data() + k * channels, channels);
      if (options_.json) {
        append_json(rows_[k], of_row, text);
      } else {
        text += kept(rows_[k].text);
        for (const double value : of_row) fmt::format_to(std::back_inserter(text), ",{:.9g}", value);
        text += '\n';
      }
    }
    print(text);
  }

  [[nodiscard]] std::vector<double> evaluate() {
    const std::size_t channels = source_.channel_count();
    std::vector<DirectionPair> pairs;
    const double theta_max = radians_from_degrees(source_.traits().theta_max_deg) + 1e-9;
    for (const DirectionRow& row : rows_) pairs.push_back(row.below_horizon ? DirectionPair() : row.pair);
    answered_ += rows_.size();
    std::vector<float> f_r(pairs.size() * channels);
    evaluate_in_parallel(source_, pairs, f_r);
    std::vector<std::uint8_t> measured(pairs.size(), 1);
    source_.measured(pairs, measured);
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      if (rows_[k].below_horizon) measured[k] = 1;
      unmeasured_ += measured[k] == 0 ? 1 : 0;
      const bool told = measured[k] != 0 || options_.filled;  // with a number
      beyond_ += told && std::max(pairs[k].i.theta, pairs[k].v.theta) > theta_max ? 1 : 0;
    }
    std::vector<double> values(f_r.begin(), f_r.end());
    for (std::size_t k = 0; k < values.size(); ++k) {
      const DirectionRow& row = rows_[k / channels];
      if (row.below_horizon) {
        values[k] = 0;
      } else if (measured[k / channels] == 0 && !options_.filled) {
        values[k] = std::numeric_limits<double>::quiet_NaN();
      } else if (options_.cosine) {
        // The sine of what is left to 90 degrees: exactly 0 there, and accurate close to it.
        values[k] *= std::sin(radians_from_degrees(90 - row.theta_v_deg));
      }
    }
    return values;
  }

  void append_json(const DirectionRow& row, std::span<const double> values, std::string& text) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    const std::vector<std::string> fields = split_fields(row.text);
    for (std::size_t k = 0; k < kept_count_; ++k) {
      const std::optional<double> number = parse_number(fields[k]);
      if (number) {
        object[header_->names[k]] = *number;
      } else {
        object[header_->names[k]] = fields[k];
      }
    }
    for (std::size_t c = 0; c < values.size(); ++c) object[channels_[c]] = values[c];
    text += std::exchange(row_written_, true) ? ",\n " : "[\n ";
    text += escape_controls(object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  }

  const BrdfSource& source_;
  const EvalOptions& options_;
  std::vector<std::string> channels_;  ///< names as they are printed
  LineReader reader_;
  std::optional<DirectionHeader> header_;  ///< its names are those of the output
  std::size_t column_count_ = 0;           ///< of the input
  std::size_t kept_count_ = 0;             ///< of them
  std::uint64_t line_number_ = 0;
  std::optional<std::uint64_t> blank_line_;
  std::vector<DirectionRow> rows_;
  std::uint64_t answered_ = 0;
  std::uint64_t beyond_ = 0;      ///< of them, pairs with a direction beyond theta_max and a value
  std::uint64_t unmeasured_ = 0;  ///< of them, pairs at which nothing was measured
  bool row_written_ = false;
};

int run_eval(const EvalOptions& options) {
  if (Status used = check_reading_options(options.given, std::span(&options.file, 1)); !used) {
    return report_error(options.file, used.error());
  }
  const Result<OpenedSource> opened = open_source(options.file, options.given);
  if (!opened) return report_error(options.file, opened.error());
  const Status done = Evaluation(*opened->source, options).run();
  return done ? 0 : report_error(kInputName, done.error());
}

}  // namespace

void add_eval(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("eval", "Evaluates f_r for the pairs of directions on standard input.");
  const auto options = std::make_shared<EvalOptions>();
  command->add_option("FILE", options->file, "A file of any readable format, kurt:NAME or kurt:FILE.json")->required();
  command->add_flag("--cosine", options->cosine, "Multiply by cos theta_v");
  command->add_flag("--filled", options->filled, "Also where nothing was measured, what the file has filled in there");
  command->add_flag("--json", options->json, "Print an array of objects");
  add_reading_options(*command, options->given);
  command->footer(
      "Standard input is CSV with a header that begins with theta_i,phi_i,theta_v,phi_v, in degrees from the normal "
      "and\n"
      "from the tangent: i towards the light, v towards the viewer. Standard output has the same rows with one column "
      "per\n"
      "channel appended, f_r in 1/sr; 0 where a theta is above 90 degrees, below the surface, and nan (in JSON null) "
      "where\n"
      "nothing was measured, such as in a hole of a table. Further columns of the input are kept; those that an "
      "earlier\n"
      "'eval' appended are worked out anew. No two columns may have one name.\n\n"
      "Example:\n"
      "  printf 'theta_i,phi_i,theta_v,phi_v\\n30,0,45,180\\n' | sbrdf eval material.sbrdf");
  command->callback([options, &exit_code] { exit_code = run_eval(*options); });
}

}  // namespace sbrdf::internal
