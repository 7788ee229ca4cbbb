#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "codec/search/held_back.h"
#include "codec/search/structure_search.h"
#include "codec/series/series.h"

namespace sbrdf::internal {

/// Directions with what a series is fitted to there.
struct SeriesDraw {
  HeldBack drawn;
  std::vector<Coordinates> places;
  /// Of the error as a sum: sum of error_weights x |f - r|, per pair and channel, is 1 where r is 0 (relative L1).
  std::vector<double> error_weights;
  std::vector<double> means;  ///< Y, of all channels
};

/// The functions of a basis at all places of a draw.
struct SeriesStructure {
  SeriesBasis basis;
  Warp warp;
  Eigen::MatrixXf fitted;  ///< [pair][term]
  Eigen::MatrixXf judged;  ///< the same of the directions that choices are made by
  Eigen::MatrixXd gram;    ///< of the first field, for weights that do not depend on what is fitted
  Eigen::VectorXd right;
};

/// Everything about a source that fits of different structures and precisions have in common.
class SeriesProblem {
 public:
  /// kInvalidFile where the mean of all channels is nowhere positive.
  [[nodiscard]] static Result<SeriesProblem> make(HeldBack fitted, HeldBack judged,
                                                  const std::vector<std::string>& channels,
                                                  const Symmetries& symmetries, double theta_max_deg,
                                                  Objective objective);

  /// The errors of make_basis; kUnsupported where a fit would take more memory than is sensible.
  [[nodiscard]] Result<SeriesStructure> structure(const SeriesShape& shape, const Warp& warp) const;

  /// How well a structure could do, by weighed squares of the first field; to compare warps of one shape with.
  [[nodiscard]] double residual(const SeriesStructure& structure) const;

  /// The series whose coefficients are multiples of 2^(-step / 8), chosen by error and size together.
  [[nodiscard]] SeriesBrdf quantise(const SeriesStructure& structure, std::uint8_t step) const;

  /// Values of the series itself, without a table, on the directions that choices are made by, channel fastest.
  [[nodiscard]] std::vector<float> judged_values(const SeriesStructure& structure, const SeriesBrdf& brdf) const;
  [[nodiscard]] const HeldBack& judged() const { return judged_.drawn; }
  [[nodiscard]] double theta_max_deg() const { return theta_max_deg_; }

 private:
  SeriesProblem() = default;

  [[nodiscard]] SeriesDraw prepare(HeldBack drawn) const;
  void choose_colours();
  void fit_first(const SeriesStructure& structure, const Eigen::VectorXf& now, SeriesBrdf& brdf, double price) const;
  void fit_colours(const SeriesStructure& structure, SeriesBrdf& brdf, double price) const;

  SeriesDraw fitted_;
  SeriesDraw judged_;
  std::vector<double> logs_;  ///< of the means of the fitted directions
  Objective objective_ = Objective::kRelL1;
  double theta_max_deg_ = kPaperThetaMaxDeg;
  SeriesBrdf common_;  ///< what all have in common: no shape, no coefficients
};

}  // namespace sbrdf::internal
