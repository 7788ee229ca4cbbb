#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

// What a format can be told. Options have names and values as text, as on the command line, whoever gives them; a row
// of the format table declares each of its own once (OptionSpec), and the declaration is what help, checks, messages,
// metadata and tests go by. Messages call an option by its name on the command line: "--samples: must be 1 to 9".

/// Of numbers.
struct Range {
  double least = 0;
  double most = std::numeric_limits<double>::max();
  bool open = false;  ///< `least` itself is out of range
};
/// Of whole numbers.
struct CountRange {
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
};

/// The text as a number within a range; kUsage saying what is wrong with it, without the name of the option.
[[nodiscard]] Result<double> number_within(std::string_view text, const Range& range);
[[nodiscard]] Result<std::uint64_t> count_within(std::string_view text, const CountRange& range);

enum class OptionKind : std::uint8_t { kNumber, kCount, kChoice, kFlag, kText };

/// When an option has a meaning: where the format is read, where it is written, or both.
enum class OptionUse : std::uint8_t { kRead, kWrite, kBoth };

/// One option of a format. Aggregate, for static tables:
///
///     {.name = "minimum-gap", .kind = OptionKind::kNumber, .unit = "DEG", .range = {0.01, 90}, .meaning = "..."}
struct OptionSpec {
  std::string_view name;  ///< in lower case with dashes, one meaning in all formats; without the leading "--"
  OptionKind kind = OptionKind::kText;
  OptionUse use = OptionUse::kWrite;
  std::string_view unit = {};  ///< how help shows the value: DEG, N, "lossless|P%"; choices and flags need none
  Range range = {};            ///< of kNumber
  CountRange counts = {};      ///< of kCount
  std::span<const std::string_view> choices = {};    ///< of kChoice
  std::string_view fallback = {};                    ///< shown as the default; empty: none, or told in the meaning
  Status (*check)(std::string_view text) = nullptr;  ///< of kText: whether it can be; the message without the name
  std::string_view meaning = {};                     ///< for help and for the format's page
};

/// Whether an option may have this value; kUsage, beginning with the option's name, otherwise.
[[nodiscard]] Status check_value(const OptionSpec& option, std::string_view text);

/// What metadata tell of how a file came to be. Either may be empty.
struct Provenance {
  std::string command;        ///< that asked for this
  std::string source_sha256;  ///< of the file that the source was read from
};

/// Options that were given, in the order of giving.
class Options {
 public:
  /// Takes the place of an earlier value. A flag has no text.
  Options& set(std::string name, std::string text = {});

  [[nodiscard]] const std::vector<std::pair<std::string, std::string>>& all() const { return given_; }
  [[nodiscard]] bool has(std::string_view name) const { return text(name).has_value(); }
  [[nodiscard]] std::optional<std::string> text(std::string_view name) const;
  /// Of a value that check_value took; nothing where the option was not given.
  [[nodiscard]] std::optional<double> number(std::string_view name) const;
  [[nodiscard]] std::optional<std::uint64_t> count(std::string_view name) const;

  /// Those that are declared and have a meaning for `use`.
  [[nodiscard]] Options select(std::span<const OptionSpec> declared, OptionUse use) const;

  Provenance provenance;
  MemoryLimit memory;  ///< of reading a file

 private:
  std::vector<std::pair<std::string, std::string>> given_;
};

/// For reading within a limit.
[[nodiscard]] inline Options within(const MemoryLimit& memory) {
  Options options;
  options.memory = memory;
  return options;
}

/// The declaration of that name that has a meaning for `use`, or nullptr.
[[nodiscard]] const OptionSpec* find_option(std::span<const OptionSpec> declared, std::string_view name, OptionUse use);

/// Whether each option that was given is declared for `use` and has a value that it may have; kUsage naming the first
/// that is not. `whose` says in such a message what has no such option: ".binary files".
[[nodiscard]] Status check_options(const Options& options, std::span<const OptionSpec> declared, OptionUse use,
                                   std::string_view whose);

}  // namespace sbrdf::internal
