#include "formats/zemax/zemax.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/core/numbers.h"
#include "formats/core/text_lines.h"

namespace sbrdf::internal {
namespace {

/// Keywords of the header; the position is that in Parser::seen_.
constexpr std::array<std::string_view, 8> kKeywords = {"Source",         "Symmetry",       "SpectralContent",
                                                       "ScatterType",    "SampleRotation", "AngleOfIncidence",
                                                       "ScatterAzimuth", "ScatterRadial"};
constexpr std::string_view kBlank = " \t\r\f\v";
constexpr double kTurnTolerance = 1e-6;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

std::optional<std::size_t> keyword_of(std::string_view word) {
  const auto* found =
      std::find_if(kKeywords.begin(), kKeywords.end(), [&](std::string_view name) { return same(name, word); });
  if (found == kKeywords.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kKeywords.begin());
}

/// The next word of `rest`, which loses it; empty at the end.
std::string_view next_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlank), rest.size()));
  const std::string_view word = rest.substr(0, std::min(rest.find_first_of(kBlank), rest.size()));
  rest.remove_prefix(word.size());
  return word;
}

/// Lines that are neither empty nor comments.
class Lines {
 public:
  explicit Lines(std::string_view text) : size_(text.size()), lines_(text) {}

  /// The next line; false at the end of the text.
  bool next() {
    while (const std::optional<TextLine> line = lines_.next()) {
      line_ = *line;
      const std::size_t first = line_.text.find_first_not_of(kBlank);
      if (first != std::string_view::npos && line_.text[first] != '#') return true;
    }
    line_ = {{}, line_.number, size_};
    ended_ = true;
    return false;
  }

  [[nodiscard]] std::string_view line() const { return line_.text; }
  [[nodiscard]] std::uint64_t remaining() const { return size_ - line_.offset; }
  /// Of the current line, or of the end of the text.
  [[nodiscard]] Error error(const std::string& message) const {
    if (ended_) return invalid_file("the file ends early: " + message, line_.offset);
    return invalid_file(fmt::format("line {}: {}", line_.number, message), line_.offset);
  }

 private:
  std::uint64_t size_;
  LineWalker lines_;
  TextLine line_;
  bool ended_ = false;
};

class Parser {
 public:
  explicit Parser(std::string_view text) : lines_(text) {}

  Result<ZemaxTable> run() {
    if (Status header = parse_header(); !header) return header.error();
    if (Status checked = check_header(); !checked) return checked.error();
    static constexpr std::array<std::string_view, 3> kTristimulus = {"TristimulusX", "TristimulusY", "TristimulusZ"};
    for (std::size_t c = 0; c < table_.channel_count(); ++c) {
      const std::string_view name = table_.spectrum == ZemaxSpectrum::kXyz ? kTristimulus.at(c) : "Monochrome";
      if (Status channel = parse_channel(name); !channel) return channel.error();
    }
    if (lines_.next()) return lines_.error("nothing may follow the last DataEnd");
    return std::move(table_);
  }

 private:
  // Up to the line that names the first channel.
  Status parse_header() {
    while (lines_.next()) {
      std::string_view rest = lines_.line();
      const std::string_view word = next_word(rest);
      if (same(word, "Monochrome") || same(word, "TristimulusX")) return ok_status();
      const std::optional<std::size_t> keyword = keyword_of(word);
      if (!keyword) return lines_.error("'" + field_text(word) + "' is no keyword of the header");
      const std::string name(kKeywords.at(*keyword));
      if (seen_.test(*keyword)) return lines_.error(name + " stands there twice");
      seen_.set(*keyword);
      if (Status value = parse_keyword(name, rest); !value) return value;
    }
    return lines_.error("no values follow the header");
  }

  Status parse_keyword(const std::string& name, std::string_view rest) {
    if (name == "SampleRotation") return parse_angles(name, rest, {-360, 360}, table_.rotations);
    if (name == "AngleOfIncidence") return parse_angles(name, rest, {0, 90}, table_.incidences);
    if (name == "ScatterAzimuth") return parse_angles(name, rest, {-360, 360}, table_.azimuths);
    if (name == "ScatterRadial") return parse_angles(name, rest, {0, 180}, table_.radials);
    const std::string_view word = next_word(rest);
    if (word.empty()) return lines_.error(name + " has no value");
    if (name == "Symmetry") return parse_choice(name, word, kZemaxSymmetryNames, table_.symmetry);
    if (name == "SpectralContent") return parse_choice(name, word, kZemaxSpectrumNames, table_.spectrum);
    if (name == "ScatterType") return parse_choice(name, word, kZemaxScatterNames, table_.scatter);
    return ok_status();  // Source: how the values came to be, in any words
  }

  template <class T, std::size_t N>
  Status parse_choice(const std::string& name, std::string_view word, const std::array<Named<T>, N>& names, T& value) {
    for (const Named<T>& choice : names) {
      if (!same(choice.name, word)) continue;
      value = choice.value;
      return ok_status();
    }
    return lines_.error(
        fmt::format("{} is '{}', which is none of {}", name, field_text(word), fmt::join(names_of(names), ", ")));
  }

  // A count, and as many angles on the lines behind it.
  Status parse_angles(const std::string& name, std::string_view rest, std::pair<double, double> range,
                      std::vector<double>& angles) {
    const std::string_view word = next_word(rest);
    const std::optional<std::uint64_t> count = parse_count(word);
    if (!count || *count == 0 || *count > kZemaxMostAngles) {
      return lines_.error(
          fmt::format("{} is followed by '{}', not by a count of 1 to {}", name, field_text(word), kZemaxMostAngles));
    }
    if (*count > lines_.remaining()) {
      return lines_.error(fmt::format("{} angles of {}, but only {} bytes are left", *count, name, lines_.remaining()));
    }
    angles.reserve(*count);
    do {
      for (std::string_view angle = next_word(rest); !angle.empty(); angle = next_word(rest)) {
        if (Status added = add_angle(name, angle, range, *count, angles); !added) return added;
      }
      if (angles.size() == *count) return ok_status();
      if (!lines_.next()) break;
      rest = lines_.line();
    } while (true);
    return lines_.error(fmt::format("{} angles of {}, but {} are announced", angles.size(), name, *count));
  }

  Status add_angle(const std::string& name, std::string_view word, std::pair<double, double> range, std::size_t count,
                   std::vector<double>& angles) {
    if (keyword_of(word) || same(word, "Monochrome") || same(word, "TristimulusX")) {
      return lines_.error(fmt::format("{} angles of {}, but {} are announced", angles.size(), name, count));
    }
    if (angles.size() == count) return lines_.error(fmt::format("more than the {} angles of {}", count, name));
    const Result<double> angle = number(word);
    if (!angle) return angle.error();
    if (*angle < range.first || *angle > range.second) {
      return lines_.error(
          fmt::format("an angle of {} is {:g}, must be {:g} to {:g} degrees", name, *angle, range.first, range.second));
    }
    if (!angles.empty() && *angle <= angles.back()) {
      return lines_.error(fmt::format("angles of {} must rise, but {:g} follows {:g}", name, *angle, angles.back()));
    }
    angles.push_back(*angle + 0.0);
    return ok_status();
  }

  // Everything that the header has to say, known at the line that names the first channel.
  Status check_header() {
    for (std::size_t k = 0; k < kKeywords.size(); ++k) {
      if (!seen_.test(k)) return lines_.error(std::string(kKeywords.at(k)) + " is missing from the header");
    }
    for (const auto& [name, angles] :
         {std::pair("SampleRotation", &table_.rotations), std::pair("ScatterAzimuth", &table_.azimuths)}) {
      if (angles->back() - angles->front() > 360 + kTurnTolerance) {
        return lines_.error(
            fmt::format("{} spans {:g} degrees, more than a turn", name, angles->back() - angles->front()));
      }
    }
    if (table_.symmetry == ZemaxSymmetry::kPlaneSymmetrical &&
        (table_.azimuths.front() < 0 || table_.azimuths.back() > 180 + kTurnTolerance)) {
      return lines_.error(fmt::format("PlaneSymmetrical files list azimuths of 0 to 180 degrees, this one {:g} to {:g}",
                                      table_.azimuths.front(), table_.azimuths.back()));
    }
    // Each count is at most 2^16 and a number takes two bytes at least, so that nothing wraps on the way.
    const std::uint64_t most = lines_.remaining() / 2;
    const std::uint64_t blocks = table_.block_count();
    const std::uint64_t rows = blocks * table_.azimuths.size();
    const std::uint64_t values = rows > most ? rows : rows * table_.radials.size() * table_.channel_count();
    if (values > most) {
      return lines_.error(fmt::format("{}{} x {} x {} x {} values are announced, but only {} bytes are left",
                                      table_.channel_count() == 1 ? "" : "3 x ", table_.rotations.size(),
                                      table_.incidences.size(), table_.azimuths.size(), table_.radials.size(),
                                      lines_.remaining()));
    }
    table_.values.reserve(values);
    table_.tis.reserve(blocks * table_.channel_count());
    return ok_status();
  }

  // The current line is the one that should name it.
  Status parse_channel(std::string_view name) {
    const bool first = table_.tis.empty();
    if (!first && !lines_.next()) return lines_.error(std::string(name) + " is missing");
    if (Status named = expect_word(name); !named) return named;
    lines_.next();
    if (Status begun = expect_word("DataBegin"); !begun) return begun;
    for (std::size_t block = 0; block < table_.block_count(); ++block) {
      if (Status parsed = parse_block(block); !parsed) return parsed;
    }
    lines_.next();
    return expect_word("DataEnd");
  }

  Status expect_word(std::string_view name) {
    std::string_view rest = lines_.line();
    const std::string_view word = next_word(rest);
    if (!same(word, name)) return lines_.error(fmt::format("'{}' where {} is to stand", field_text(word), name));
    if (!next_word(rest).empty()) return lines_.error(fmt::format("nothing may follow {}", name));
    return ok_status();
  }

  [[nodiscard]] std::string block_text(std::size_t block) const {
    return fmt::format("rotation {:g}, incidence {:g}", table_.rotations[block / table_.incidences.size()],
                       table_.incidences[block % table_.incidences.size()]);
  }

  Status parse_block(std::size_t block) {
    lines_.next();
    std::string_view rest = lines_.line();
    const std::string_view word = next_word(rest);
    if (!same(word, "TIS")) {
      return lines_.error(fmt::format("'{}' where TIS of {} is to stand", field_text(word), block_text(block)));
    }
    const Result<double> tis = number(next_word(rest));
    if (!tis) return tis.error();
    if (!next_word(rest).empty()) return lines_.error("nothing may follow the value of TIS");
    table_.tis.push_back(*tis);
    for (std::size_t row = 0; row < table_.azimuths.size(); ++row) {
      if (Status parsed = parse_row(block, row); !parsed) return parsed;
    }
    return ok_status();
  }

  Status parse_row(std::size_t block, std::size_t row) {
    lines_.next();
    std::string_view rest = lines_.line();
    std::size_t count = 0;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest), ++count) {
      if (count == 0 && (same(word, "TIS") || same(word, "DataEnd"))) break;
      if (count == table_.radials.size()) return row_error(block, row, "more numbers than");
      const Result<double> value = number(word);
      if (!value) return value.error();
      table_.values.push_back(*value);
    }
    if (count < table_.radials.size()) return row_error(block, row, fmt::format("{} numbers, not", count));
    return ok_status();
  }

  [[nodiscard]] Error row_error(std::size_t block, std::size_t row, const std::string& what) const {
    return lines_.error(fmt::format("{} the {} of ScatterRadial, at {}, azimuth {:g}", what, table_.radials.size(),
                                    block_text(block), table_.azimuths[row]));
  }

  [[nodiscard]] Result<double> number(std::string_view word) const {
    if (word.empty()) return lines_.error("a number is missing");
    const FieldNumber value = read_field(word);
    if (value.kind != FieldNumber::Kind::kFinite) return lines_.error("'" + field_text(word) + "' is no finite number");
    if (std::abs(value.value) <= kZemaxLargest) return value.value;
    return lines_.error(fmt::format("'{}' is beyond {:g}", field_text(word), kZemaxLargest));
  }

  Lines lines_;
  ZemaxTable table_;
  std::bitset<kKeywords.size()> seen_;
};

}  // namespace

Result<ZemaxTable> parse_zemax(std::string_view text) { return Parser(text).run(); }

bool recognises_zemax(std::span<const std::byte> head) {
  Lines lines(std::string_view(reinterpret_cast<const char*>(head.data()), head.size()));
  std::size_t keywords = 0;
  while (keywords < 2 && lines.next()) {
    std::string_view rest = lines.line();
    const std::string_view word = next_word(rest);
    if (keyword_of(word) && !next_word(rest).empty()) {
      ++keywords;
    } else if (keywords == 0) {
      return false;
    }
  }
  return keywords == 2;
}

}  // namespace sbrdf::internal
