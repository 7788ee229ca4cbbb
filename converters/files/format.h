#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What a format can hold or do beyond one material as a whole. Code asks for these and never for a format by name.
enum class Capability : std::uint8_t {
  kRead = 1,            ///< `open` is there
  kWrite = 2,           ///< `save` is there
  kParts = 4,           ///< some directions can be loaded, or cut out, by themselves
  kLevels = 8,          ///< coarser levels of detail can be loaded by themselves
  kBundled = 16,        ///< files go into a bundle
  kManyMaterials = 32,  ///< one file, many materials: `material` and an option "material" choose one
  kMetadata = 64,       ///< files tell how they came to be (Provenance)
};

class Capabilities {
 public:
  constexpr Capabilities(std::initializer_list<Capability> list) {
    for (const Capability capability : list) bits_ = static_cast<std::uint8_t>(bits_ | bit(capability));
  }
  [[nodiscard]] constexpr bool has(Capability capability) const { return (bits_ & bit(capability)) != 0; }

 private:
  [[nodiscard]] static constexpr std::uint8_t bit(Capability capability) {
    return static_cast<std::uint8_t>(capability);
  }
  std::uint8_t bits_ = 0;
};

/// What a file of a format can say about a material; `sbrdf formats` prints it. Writers tell in their reports what of a
/// source was lost.
struct Holds {
  bool anisotropic = true;            ///< values may depend on both azimuths
  bool non_reciprocal = true;         ///< f(i,v) and f(v,i) may differ
  bool unmeasured = false;            ///< directions without a value can be told from black
  bool negatives = true;              ///< values below 0 come back as they are
  std::string_view channels = "RGB";  ///< for people: "RGB", "1 or 3", "any", "1"
  std::string_view values = "";       ///< for people: "float32", "float64", "lossless or bounded"
};

/// Something a conversion changed or lost, for people (`text`) and for scripts (`key`, `value`).
struct Remark {
  std::string key;  ///< such as "reciprocity_residual_percent"
  double value = 0;
  std::string text;  ///< such as "reciprocity residual 3.2 %: f(i,v) and f(v,i) were replaced by their mean"
};

/// What is to be said about a file that was written.
struct Report {
  std::vector<Remark> remarks;
  std::vector<Finding> findings;  ///< what the reader of the source saw in its file
  std::uint64_t bytes = 0;        ///< of the file that was written
};

/// [{"key", "value", "text"}, ...].
[[nodiscard]] nlohmann::ordered_json remarks_json(std::span<const Remark> remarks);
/// For metadata of tables, on one line: {"findings": [...], "remarks": [...]}.
[[nodiscard]] std::string report_json(const Report& report);

/// "3.2 %", or "infinite".
[[nodiscard]] std::string percent_text(double value);
/// "41 cells below the horizon"; nothing where there are none.
void remark_count(Report& report, const char* key, std::uint64_t count, const std::string& what);
/// Of a source that was not reciprocal and was made so.
void remark_reciprocity(Report& report, double difference_percent);

/// The whole of `source`, a few MB at a time. interrupted_error() where `progress` asked to stop.
[[nodiscard]] Status copy_bytes(const ByteSource& source, ByteSink& sink, const Progress& progress);

/// How sure a row is that a file is of its format.
enum class Match : std::uint8_t {
  kNone,
  kPossible,  ///< it could begin like one, but cannot be whole: `open` says what is wrong if no other row is surer
  kDamaged,   ///< it certainly begins like one, but cannot be whole: the same
  kWhole,     ///< it should be one; `open` may still find it damaged further in
};

/// One row of the format table. A new format is one row here, a folder in converters/files and one in formats/, and a
/// page in specs/. Functions are called with options that check_options took; open_source and save_source see to it.
struct Format {
  std::string_view name;
  /// Decides what is written: no two rows that are written have the same. What is read is recognised by content.
  std::string_view extension;
  std::string_view description;
  std::string_view page;  ///< in specs/; it tells of every option
  Capabilities capabilities;
  Holds holds;
  std::span<const OptionSpec> options;

  /// `head` are the first kHeadSize bytes, or all where there are fewer, and at least one; of text that no row is sure
  /// of, the first kTextHeadSize after these. No row may be sure of a file that another one is sure of, so that their
  /// order says nothing.
  Match (*recognise)(std::span<const std::byte> head, std::uint64_t size) = nullptr;

  /// The source may keep the bytes and read from them as it is evaluated.
  Result<std::unique_ptr<BrdfSource>> (*open)(std::shared_ptr<const ByteSource> bytes,
                                              const Options& options) = nullptr;

  /// Writes the whole file and nothing that `open` would refuse: a source that cannot be such a file is an error. What
  /// was written before an error is of no use. interrupted_error() where `progress` asked to stop.
  Status (*save)(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                 const Progress& progress) = nullptr;

  /// A second file that belongs to each has its name followed by this, such as ".json"; empty: there is none.
  /// `is_beside` tells by the beginning of a file whether it is such a one, so that no other is replaced.
  std::string_view beside = {};
  bool (*is_beside)(std::string_view text) = nullptr;

  /// The names of further files, in its folder, that such a file consists of; none where it is damaged.
  std::vector<std::string> (*consists_of)(const ByteSource& bytes) = nullptr;

  /// The library that reads the files is brought down by some damaged ones: a program tries each in a process of its
  /// own first (formats/os/trial.h).
  bool fragile = false;

  /// Options that contradict each other; may be absent.
  Status (*check)(const Options& options) = nullptr;

  /// Of kManyMaterials: the bytes of one material as a file of its own. kUsage, with names near to it, where there is
  /// none of that name; kUnsupported where unpacking it takes more memory than allowed.
  Result<std::shared_ptr<const ByteSource>> (*material)(std::shared_ptr<const ByteSource> bytes, std::string_view name,
                                                        const MemoryLimit& limit) = nullptr;
};

/// As much of a file as tells its format.
inline constexpr std::size_t kHeadSize = 512;
/// As much of a text as tells its format, behind the longest comments that anybody puts before it.
inline constexpr std::size_t kTextHeadSize = 65536;

}  // namespace sbrdf::internal
