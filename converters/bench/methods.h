#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/bench/contender.h"
#include "converters/bench/quality.h"
#include "converters/bench/workshop.h"
#include "converters/files/options.h"

namespace sbrdf::internal {

/// How large something is made.
struct Variant {
  std::string name;           ///< for people: "8,911 samples", "90 x 90 x 180 cells"
  std::uint64_t samples = 0;  ///< of slices; 0 otherwise
  Options options = {};       ///< of writing, for other formats
};

/// A material kept one way: what is opened, and how. What `open` does is the time to the first value: it copies the
/// file's bytes, as from the cache of a disk, and makes of them all that evaluating takes.
struct Prepared {
  std::function<Result<std::unique_ptr<Contender>>()> open;
  std::optional<std::uint64_t> file_bytes;  ///< none for a built-in model
};

/// What the variants of methods are made by.
struct VariantChoice {
  std::vector<std::uint64_t> samples;
  std::vector<std::string> grids;  ///< of dense tables, in the words of --grid
  Options rgl;                     ///< of writing RGL files
};

/// One way to keep and evaluate materials. A row of the registry: whoever adds one there finds it in every table and
/// chart.
struct Method {
  std::string_view name;  ///< for people; never changes its meaning
  /// Why a material cannot be measured this way, such as "its channels are not R, G, B"; empty where it can.
  std::string_view (*left_out)(const BrdfSource& source);
  std::vector<Variant> (*variants)(const VariantChoice& choice);
  Result<Prepared> (*prepare)(Workshop& workshop, const Variant& variant, const Progress& progress);
  /// Opens a sliced file, for the tables of growth; nullptr for what has no slices.
  Result<std::unique_ptr<Contender>> (*open_sliced)(std::span<const std::byte> bytes) = nullptr;
  double wild_percent = kWildPercent;  ///< see there
};

[[nodiscard]] std::span<const Method> bench_methods();

/// "8,911 samples".
[[nodiscard]] Variant samples_variant(std::uint64_t samples);

}  // namespace sbrdf::internal
