#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/mask/direction_mask.h"
#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

class ByteSource;
struct DecodedSliced;
struct DenseTable;
class SchemeSource;

/// Something the reader saw in a file that its user should know: negative cells, unmeasured cells and the like.
struct Finding {
  std::string what;         ///< "cells with a negative channel", in the plural
  std::uint64_t count = 0;  ///< how many
  std::uint64_t total = 0;  ///< out of how many
};

/// What holds for a source as a whole.
struct SourceTraits {
  std::string format;                 ///< name of its row in the table of formats, such as "merl"
  std::string description;            ///< one line for people
  std::vector<std::string> channels;  ///< names in the order of the values, such as R, G, B
  bool isotropic = false;             ///< values depend on phi_i - phi_v only
  bool reciprocal = false;            ///< f(i,v) = f(v,i) by construction
  std::vector<Finding> findings;      ///< what was seen on opening; BrdfSource::findings has all
  /// Both directions were measured, or are known by a formula, up to here; beyond, values are made up.
  double theta_max_deg = 90;
  std::string beyond_theta_max;      ///< what is given there: "the value held at theta_max"
  double slice_theta_max_deg = 90;   ///< how far slices go unless somebody says otherwise: at most theta_max_deg
  std::vector<std::uint32_t> shape;  ///< of a dense table: cells along each axis, slowest first; empty for what is none
};

/// Anything that can be evaluated: an analytic model, a dense table, a measured file, a sliced file. The single meeting
/// point of all conversions: each reader makes one, each writer takes one. Immutable after construction; all members
/// may be called from several threads at once.
class BrdfSource {
 public:
  BrdfSource() = default;
  BrdfSource(const BrdfSource&) = delete;
  BrdfSource& operator=(const BrdfSource&) = delete;
  virtual ~BrdfSource() = default;

  [[nodiscard]] virtual const SourceTraits& traits() const = 0;

  /// f_r [1/sr], without any cosine. `values` has pairs.size() x channels entries, channel fastest. theta beyond pi/2
  /// gives 0; values are finite, and may be negative where the source's data are.
  virtual void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const = 0;

  /// The same for vectors x, y, z with the normal at (0, 0, 1), of any length but 0; 0 where one points below the
  /// horizon or is no direction. `w_i` and `w_v` have the same length. Values agree with those of the angles to
  /// rounding.
  virtual void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                std::span<float> values) const;

  /// All that traits().findings has, and what takes a look at the whole file: that is taken when it is first asked for.
  [[nodiscard]] virtual const std::vector<Finding>& findings() const { return traits().findings; }
  /// traits() with all findings(), for reports.
  [[nodiscard]] SourceTraits reported_traits() const;

  /// Which pairs were measured: `flags`, one for each pair, become 1, or 0 where nothing was measured and what
  /// `evaluate` says is made up. Pairs below the horizon count as measured: 0 is right there.
  virtual void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const;

  /// Cells that are fine enough to tell where `measured` says no: those of a table. Nothing where every pair above the
  /// horizon was measured, so that nobody need ask.
  [[nodiscard]] virtual std::optional<MaskGrid> mask_grid() const { return std::nullopt; }

  // What a writer may use instead of evaluating, so that copies lose nothing. A source offers what it has; a writer
  // asks for what it can use and falls back to `evaluate`. Nobody needs to know which class a source is.

  /// The slices of a source that consists of slices, such as a sliced file; valid as long as the source. nullptr
  /// otherwise.
  [[nodiscard]] virtual const DecodedSliced* sliced() const { return nullptr; }

  /// The grid of a source that consists of one, with the value at each node as it was read; valid as long as the
  /// source. nullptr otherwise, and where the table is not of a kind that a grid describes (patches, scattered
  /// samples).
  [[nodiscard]] virtual const DenseTable* table() const { return nullptr; }

  /// How the file came to be: a JSON object on one line where the format has metadata (specs/sbrdf.md, section 8).
  [[nodiscard]] virtual std::string_view metadata() const { return {}; }

  /// This source itself where it consists of uniform samples. nullptr otherwise.
  [[nodiscard]] virtual const SchemeSource* uniform_samples() const { return nullptr; }

  /// The file of a format (the name of its row) that says exactly what this source says: its bytes are a perfect copy.
  /// nullptr where there is none of that format, and where options of reading changed the meaning of the values.
  [[nodiscard]] virtual std::shared_ptr<const ByteSource> stored(std::string_view /*format*/) const { return nullptr; }

  [[nodiscard]] std::size_t channel_count() const { return traits().channels.size(); }
};

/// `source.evaluate` over many pairs on all cores: the same values.
void evaluate_in_parallel(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<float> values);
/// `source.evaluate_vectors` likewise.
void evaluate_in_parallel(const BrdfSource& source, std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                          std::span<float> values);

/// Whether a vector of any length points to the upper hemisphere, or along its rim; not so if it is 0 or not finite.
[[nodiscard]] inline bool above_horizon(const glm::vec3& w) {
  const float length = std::abs(w.x) + std::abs(w.y) + w.z;
  return w.z >= 0 && length > 0 && std::isfinite(length);
}

}  // namespace sbrdf::internal
