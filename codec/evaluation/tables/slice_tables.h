#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "codec/evaluation/tables/lattice_tables.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// A sliced BRDF as the flat arrays that the kernel of the evaluator reads: what specs/conventions.md calls
/// reconstruction, with all that does not depend on the point worked out. Immutable once it is made; a plain struct, as
/// LatticeTables.
///
/// In the exact form curves are splines, and `knot_buckets`, `places` and `row_values` tell of their knots. In the
/// pre-sampled form they are straight between rows, of which `row_buckets` and `row_values` tell. In the dense form
/// there are none, and `crossing_values` are those of all points of a lattice, guide and all, which the lattice's
/// tables do not number.
///
/// Values are those of the value domain less the guide, as float32. Channels are worked out in groups of kLanes; what
/// the last group reads beyond the last channel means nothing.
struct SliceTables {
  static constexpr std::size_t kLanes = 4;

  enum class Form : std::uint8_t { kExact, kPresampled, kDense };

  /// How a line of the lattice is found on the curve of its slice: at the turn +-x + offset, which the slice's period
  /// and mirrors make a place. Samples are the knots of a curve, the first one of a periodic slice again at its end.
  /// Behind the last, at kBeyond, stands its value once more, so that the end is found as any other knot is.
  struct Line {
    std::uint32_t first_bucket = 0;  ///< of its curve; it begins with the first knot, or row
    std::uint32_t offset = 0;        ///< a turn
    std::uint32_t shape = 0;         ///< the numbers below
  };
  static_assert(sizeof(Line) == LatticeTables::kLineWords * sizeof(std::uint32_t));
  static constexpr std::uint32_t kBackwards = 0x80000000U;  ///< the sign is -1
  static constexpr std::uint32_t kMirrored = 0x10000U;
  static constexpr std::uint32_t kTurnShift = 8;    ///< from this bit, five: log2 of the slice's periods in the longest
  static constexpr std::uint32_t kBucketShift = 0;  ///< likewise: see PlaceSearch

  /// Places on a curve are found through buckets of equal width, which hold no more than one knot nearly always.
  struct KnotBucket {
    std::uint32_t knot = 0;  ///< the last one at or before the bucket's beginning
    std::int32_t begin = 0;  ///< its place, that of the next one, and of the one after it
    std::int32_t split = 0;
    std::int32_t end = 0;
  };
  /// In the pre-sampled form, rows of a bucket are equally far apart.
  struct RowBucket {
    std::uint32_t row = 0;         ///< at its beginning
    std::uint32_t step_shift = 0;  ///< log2 of the places from one to the next
  };

  /// What brings a group of channels back from the value domain, per channel.
  struct Group {
    std::array<float, kLanes> reference{};
    std::array<float, kLanes> floor{};
    std::array<float, kLanes> at_floor{};  ///< v of the floor; in linear values below all of them
    std::array<float, kLanes> at_zero{};   ///< v of 0
    std::array<float, kLanes> least{};
    std::array<float, kLanes> most{};
  };

  /// What some points need, as the kernel says.
  struct Needs {
    std::vector<std::uint32_t> corners;  ///< in LatticeTables::corners
    std::vector<std::uint32_t> lines;    ///< in words of `lines`
  };

  /// `tables` are those of this lattice. With `only` nothing else can be evaluated, and little is worked out.
  SliceTables(const SlicedBrdf& sliced, const Lattice& lattice, std::shared_ptr<const LatticeTables> tables,
              const Needs* only = nullptr);
  /// What the kernel takes to say what points need, and no more.
  SliceTables(const SlicedBrdf& sliced, std::shared_ptr<const LatticeTables> tables);

  /// Groups of channels that come back from this domain and are kept within these bounds, per channel.
  void add_groups(const ValueDomain& domain, const std::vector<ValueRange>& bounds);

  /// Without the tables of the lattice.
  [[nodiscard]] std::size_t bytes() const;

  std::shared_ptr<const LatticeTables> lattice;
  std::size_t channels = 0;
  std::uint32_t row_size = 0;  ///< numbers of a row in `row_values`
  Form form = Form::kExact;
  bool log = false;
  bool guided = false;
  double guide_ratio = 1;
  GreyShares grey_shares;
  std::vector<Group> groups;
  std::vector<float> crossing_values;  ///< per crossing, channel fastest
  std::vector<Line> lines;             ///< axis by axis, then the guide's
  std::vector<std::int32_t> places;    ///< of the knots of all curves; exact form only
  /// Exact: of a knot, the values of all channels, then their slopes [1/kWidthUnit]. Pre-sampled: values alone.
  std::vector<float> row_values;
  std::vector<KnotBucket> knot_buckets;
  std::vector<RowBucket> row_buckets;

 private:
  class Maker;
};

}  // namespace sbrdf::internal
