#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "converters/bench/methods.h"
#include "converters/bench/quality.h"
#include "converters/bench/timing.h"
#include "converters/bench/workshop.h"
#include "converters/bench/yardstick.h"
#include "converters/source/progress.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Every method on every material, timed and judged in one run (specs/bench.md). Each is verified before it is timed.

/// How much is measured.
struct BenchSettings {
  TimingOptions timing;
  std::size_t timed_pairs = 65'536;
  std::uint64_t judged_pairs = 100'000;
  VariantChoice variants = {
      {1000, 3000, 8911, 18'721}, {"utia", "5:5:5:5", "half-difference/30:3:5:10", "half-difference/15:2:3:5"}, {}};
  std::vector<std::uint64_t> growth_samples = {1000, 3000, 8911, 18'721, 50'000, 120'000, 350'000};
  std::vector<std::size_t> batches = {1, 4, 16, 64, 1024, 65'536};
  std::uint64_t growth_batch_samples = 8911;  ///< of the file that growth against batches and threads is measured on
  std::size_t search_evaluations = kDefaultSearchEvaluations;  ///< of the files of the rows, see SearchedStructure
  std::uint64_t least_array_bytes = std::uint64_t{1} << 28U;   ///< of the arrays that memory is measured on
};

/// Medians of nine.
[[nodiscard]] BenchSettings full_settings();
/// Medians of three, few samples, structures that are hardly searched for: to see that all works.
[[nodiscard]] BenchSettings quick_settings();

/// One method on one material. Times are of one core, for one evaluation of all channels from two unit vectors.
struct BenchRow {
  std::string material;
  std::string method;
  std::string variant;               ///< of the method: "8,911 samples"; may be empty
  std::uint64_t samples = 0;         ///< of slices; 0 otherwise
  double single_ns = 0;              ///< one pair for each call
  double batch_ns = 0;               ///< all pairs in one call
  double yardstick_ns = 0;           ///< the plain look-up, its repetitions mixed with those of the two
  double first_value_ms = 0;         ///< opening the file and one evaluation, on all cores, time that passes
  std::uint64_t resident_bytes = 0;  ///< by how much the heap has grown when all pairs were evaluated
  std::optional<std::uint64_t> file_bytes = {};  ///< none for a built-in model
  Quality quality = {};

  [[nodiscard]] double single_ratio() const { return single_ns / yardstick_ns; }
  [[nodiscard]] double batch_ratio() const { return batch_ns / yardstick_ns; }
};

/// What a time is drawn against.
enum class GrowthAxis : std::uint8_t { kSamples, kBatch, kThreads };
inline constexpr std::array kGrowthAxisNames = {
    Named{"samples", GrowthAxis::kSamples}, Named{"batch", GrowthAxis::kBatch}, Named{"threads", GrowthAxis::kThreads}};

/// One point of a growth table.
struct GrowthRow {
  std::string material;
  std::string method;
  GrowthAxis axis = GrowthAxis::kSamples;
  std::uint64_t at = 0;  ///< samples, pairs in a call, or threads
  double ns = 0;         ///< for one evaluation; along kThreads time that passes, else of the one core
  double yardstick_ns = 0;
  std::uint64_t resident_bytes = 0;  ///< along kSamples; else 0

  [[nodiscard]] double ratio() const { return ns / yardstick_ns; }
};

struct BenchReport {
  std::vector<BenchRow> rows;
  std::vector<GrowthRow> growth;  ///< of the first isotropic material and of the first that is not
  double yardstick_ns = 0;        ///< median of those of the rows
  MemorySpeed memory;
  std::vector<std::string> left_out;  ///< "MATERIAL: METHOD: why"
};

/// Everything. Work on many threads is made of the same pieces whatever their number, so that all but the times, the
/// resident bytes and what follows from these is the same for every run.
///
/// kDifference where a method fails verify(); the errors of opening, slicing and writing; each message begins with the
/// material and the method. interrupted_error().
[[nodiscard]] Result<BenchReport> run_bench(std::span<const BenchMaterial> materials, const BenchSettings& settings,
                                            const Progress& progress);

/// The growth tables of one material, for each method that has slices.
[[nodiscard]] Result<std::vector<GrowthRow>> measure_growth(Workshop& workshop, const BenchSettings& settings,
                                                            const VectorPairs& pairs, const Progress& progress);

/// Work that evaluates `pairs` in calls of `batch` pairs each, into `values`. References must outlive it.
[[nodiscard]] TimedWork evaluation_work(const Contender& contender, const VectorPairs& pairs, std::size_t batch,
                                        std::vector<float>& values);
/// Work that looks them up in the yardstick.
[[nodiscard]] TimedWork yardstick_work(const VectorPairs& pairs, std::vector<float>& values);

/// "MATERIAL: METHOD, VARIANT: message".
[[nodiscard]] Error in_context(const Error& error, const std::string& material, std::string_view method,
                               std::string_view variant = {});

}  // namespace sbrdf::internal
