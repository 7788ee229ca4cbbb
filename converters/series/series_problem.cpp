#include "converters/series/series_problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "codec/frame/frame.h"
#include "converters/series/integer_fit.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;
using Eigen::VectorXf;

constexpr std::size_t kMostFunctions = std::size_t{1} << 26U;  // values of functions at places: 256 MB
constexpr std::size_t kBlocks = 16;    // of rows, which are summed apart, so that threads change no bit
constexpr double kFirstError = 0.05;   // of the logarithm, before any is known
constexpr double kSharpestSlope = 50;  // of what a logarithm that is off does to the value, over what it does at first
constexpr double kStepPerRootPrice = 8;  // the step that a price of bits asks for: tried on seven materials
constexpr double kFarthestColour = 20;   // ratios beyond say nothing of colours

/// sum over rows of weight x row' row, and of weight x target x row'.
void add_squares(const MatrixXf& rows, const VectorXf& weights, const VectorXf& targets, MatrixXd& gram,
                 VectorXd& right) {
  const Index count = rows.rows();
  const Index terms = rows.cols();
  std::vector<MatrixXf> grams(kBlocks);
  std::vector<VectorXf> rights(kBlocks);
  parallel_for(kBlocks, [&](std::uint64_t block) {
    const Index first = count * static_cast<Index>(block) / static_cast<Index>(kBlocks);
    const Index size = count * static_cast<Index>(block + 1) / static_cast<Index>(kBlocks) - first;
    const VectorXf roots = weights.segment(first, size).cwiseSqrt();
    const MatrixXf scaled = roots.asDiagonal() * rows.middleRows(first, size);
    grams[block] = MatrixXf::Zero(terms, terms);
    grams[block].selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
    rights[block] = scaled.transpose() * roots.cwiseProduct(targets.segment(first, size));
  });
  gram = MatrixXd::Zero(terms, terms);
  right = VectorXd::Zero(terms);
  for (std::size_t block = 0; block < kBlocks; ++block) {
    gram.triangularView<Eigen::Lower>() += grams[block].cast<double>();
    right += rights[block].cast<double>();
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
}

MatrixXf functions_at(const SeriesBasis& basis, const Warp& warp, const std::vector<Coordinates>& places) {
  MatrixXf functions(static_cast<Index>(places.size()), static_cast<Index>(basis.terms.size()));
  parallel_blocks(places.size(), 512, [&](std::size_t first, std::size_t size) {
    BasisFactors factors;
    for (std::size_t k = first; k < first + size; ++k) {
      evaluate_factors(basis, warp, places[k], factors);
      for (std::size_t n = 0; n < basis.terms.size(); ++n) {
        const SeriesTerm& t = basis.terms[n];
        functions(static_cast<Index>(k), static_cast<Index>(n)) =
            static_cast<float>(factors.theta_h[t.a] * factors.theta_d[t.b] * factors.harmonics[t.harmonic]);
      }
    }
  });
  return functions;
}

VectorXf field_at(const MatrixXf& functions, const SeriesBrdf& brdf, std::size_t field) {
  VectorXf values = VectorXf::Zero(functions.rows());
  const auto step = static_cast<float>(brdf.step());
  for (std::size_t n = 0; n < brdf.coefficients[field].size(); ++n) {
    const std::int32_t q = brdf.coefficients[field][n];
    if (q != 0) values += functions.col(static_cast<Index>(n)) * (step * static_cast<float>(q));
  }
  return values;
}

// Bits of saying which it is: fewer for low degrees.
std::vector<double> first_bits(const SeriesBasis& basis) {
  std::vector<double> bits;
  for (const SeriesTerm& t : basis.terms) bits.push_back(2 + 4.0 * t.level / kSeriesLevels);
  return bits;
}

double median_positive(std::vector<double> values) {
  const auto end = std::remove_if(values.begin(), values.end(), [](double v) { return !(v > 0); });
  values.erase(end, values.end());
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

SeriesDraw SeriesProblem::prepare(HeldBack drawn) const {
  SeriesDraw draw;
  const FrameGeometry& frame = geometry(FrameId::kHalfDifference);
  const std::size_t channels = common_.channel_count();
  double sum = 0;
  for (std::size_t k = 0; k < drawn.values.size(); ++k) {
    sum += drawn.weights[k / channels] * std::abs(static_cast<double>(drawn.values[k]));
  }
  const double floor = mre_floor(drawn);
  for (std::size_t k = 0; k < drawn.pairs.size(); ++k) {
    draw.places.push_back(frame.coordinates(drawn.pairs[k]));
    double mean = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const double f = drawn.values[k * channels + c];
      mean += f / static_cast<double>(channels);
      const double of_sum = drawn.weights[k] / sum;
      const double of_mean = drawn.weights[k] / (static_cast<double>(channels) * std::max(std::abs(f), floor));
      draw.error_weights.push_back(objective_ == Objective::kMre     ? of_mean
                                   : objective_ == Objective::kRelL1 ? of_sum
                                                                     : 0.5 * (of_mean + of_sum));
    }
    draw.means.push_back(mean);
  }
  draw.drawn = std::move(drawn);
  return draw;
}

Result<SeriesProblem> SeriesProblem::make(HeldBack fitted, HeldBack judged, const std::vector<std::string>& channels,
                                          const Symmetries& symmetries, double theta_max_deg, Objective objective) {
  SeriesProblem problem;
  problem.objective_ = objective;
  problem.theta_max_deg_ = theta_max_deg;
  problem.common_.channels = channels;
  problem.common_.symmetries = symmetries;
  problem.fitted_ = problem.prepare(std::move(fitted));
  problem.judged_ = problem.prepare(std::move(judged));
  const double median = median_positive(problem.fitted_.means);
  if (!(median > 0)) return invalid_file("the mean of all channels is nowhere positive; this is no reflectance");
  SeriesBrdf& common = problem.common_;
  common.reference_step = static_cast<std::int32_t>(std::lround(8 * std::log2(median)));
  const DomainMap<double> map(common.domain(), 0);
  double most = 0;
  for (const double mean : problem.fitted_.means) {
    problem.logs_.push_back(map.forward(mean));
    most = std::max(most, map.forward(std::abs(mean)));
  }
  common.most_step = static_cast<std::int32_t>(std::ceil(8 * most)) + 1;
  const std::vector<float>& values = problem.fitted_.drawn.values;
  common.negative = std::any_of(values.begin(), values.end(), [](float f) { return f < 0; });
  problem.choose_colours();
  return problem;
}

void SeriesProblem::choose_colours() {
  const std::size_t channels = common_.channel_count();
  common_.mean_colour.assign(channels, static_cast<std::int32_t>(kColourUnit));
  if (channels == 1) return;
  const auto size = static_cast<Index>(channels);
  VectorXd mean = VectorXd::Zero(size);
  MatrixXd spread = MatrixXd::Zero(size, size);
  double sum = 0;
  for (std::size_t k = 0; k < fitted_.means.size(); ++k) {
    const double y = fitted_.means[k];
    VectorXd ratio(size);
    for (std::size_t c = 0; c < channels; ++c)
      ratio[static_cast<Index>(c)] = fitted_.drawn.values[k * channels + c] / y;
    if (!(ratio.cwiseAbs().maxCoeff() < kFarthestColour)) continue;
    const double weight = fitted_.drawn.weights[k] * std::abs(y);
    sum += weight;
    mean += weight * ratio;
    spread += weight * ratio * ratio.transpose();
  }
  if (!(sum > 0)) return;
  mean /= sum;
  spread = spread / sum - mean * mean.transpose();
  std::int32_t left = static_cast<std::int32_t>(static_cast<double>(channels) * kColourUnit);
  for (std::size_t c = 0; c + 1 < channels; ++c) {
    common_.mean_colour[c] = static_cast<std::int32_t>(std::lround(mean[static_cast<Index>(c)] * kColourUnit));
    left -= common_.mean_colour[c];
  }
  common_.mean_colour.back() = left;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(spread);
  common_.component_count =
      static_cast<std::uint32_t>(std::min<std::size_t>(channels - 1, channels == 3 ? 2 : kMostComponents));
  if (channels == 3) {
    const VectorXd first = axes.eigenvectors().col(2);
    const double x = (first[0] - first[1]) / std::sqrt(2.0);
    const double y = (first[0] + first[1] - 2 * first[2]) / std::sqrt(6.0);
    const double turn = std::atan2(y, x) / kPi;  // half turns; a component may point either way
    common_.colour_turn = static_cast<std::uint8_t>(std::lround(256 * (turn - std::floor(turn))) % 256);
    return;
  }
  for (std::uint32_t j = 0; j < common_.component_count; ++j) {
    const VectorXd axis = axes.eigenvectors().col(size - 1 - static_cast<Index>(j));
    const double scale = 127 / axis.cwiseAbs().maxCoeff();
    std::vector<std::int8_t>& component = common_.components.emplace_back();
    for (Index c = 0; c < size; ++c) component.push_back(static_cast<std::int8_t>(std::lround(scale * axis[c])));
  }
}

Result<SeriesStructure> SeriesProblem::structure(const SeriesShape& shape, const Warp& warp) const {
  Result<SeriesBasis> basis = make_basis(shape, common_.symmetries);
  if (!basis) return basis.error();
  if (basis->terms.size() * (fitted_.places.size() + judged_.places.size()) > kMostFunctions) {
    return unsupported("a series of " + std::to_string(basis->terms.size()) + " terms takes too much memory to fit");
  }
  SeriesStructure made{*std::move(basis), warp, {}, {}, {}, {}};
  made.fitted = functions_at(made.basis, warp, fitted_.places);
  made.judged = functions_at(made.basis, warp, judged_.places);
  const DomainMap<double> map(common_.domain(), 0);
  const double floor = common_.domain().floor(0);
  VectorXf weights(made.fitted.rows());
  VectorXf targets(made.fitted.rows());
  const std::size_t channels = common_.channel_count();
  for (std::size_t k = 0; k < fitted_.means.size(); ++k) {
    double weight = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      // As far as a channel follows the mean.
      const double f = std::abs(static_cast<double>(fitted_.drawn.values[k * channels + c]));
      weight += fitted_.error_weights[k * channels + c] * std::max(f, floor);
    }
    weights[static_cast<Index>(k)] = static_cast<float>(weight / kFirstError);
    targets[static_cast<Index>(k)] = static_cast<float>(logs_[k]);
  }
  add_squares(made.fitted, weights, targets, made.gram, made.right);
  return made;
}

double SeriesProblem::residual(const SeriesStructure& structure) const {
  MatrixXd matrix = structure.gram;
  matrix.diagonal() *= 1 + 1e-6;
  const VectorXd best = matrix.llt().solve(structure.right);
  return -structure.right.dot(best);  // less the same constant for all
}

void SeriesProblem::fit_first(const SeriesStructure& structure, const VectorXf& now, SeriesBrdf& brdf,
                              double price) const {
  const double step = brdf.step();
  IntegerProblem problem{structure.gram, structure.right, price, first_bits(structure.basis)};
  if (now.size() > 0) {
    const DomainMap<double> map(common_.domain(), 0);
    const double floor = common_.domain().floor(0);
    const std::size_t channels = common_.channel_count();
    std::vector<double> shares(fitted_.means.size());  // of the error, where Y is off by a part of itself
    double off_sum = 0;
    double sum = 0;
    for (std::size_t k = 0; k < shares.size(); ++k) {
      const double slope = std::max(std::abs(fitted_.means[k]), floor);
      for (std::size_t c = 0; c < channels; ++c) {
        const double f = std::abs(static_cast<double>(fitted_.drawn.values[k * channels + c]));
        shares[k] += fitted_.error_weights[k * channels + c] * std::max(f, floor) / slope;
      }
      off_sum += shares[k] * slope * std::abs(logs_[k] - static_cast<double>(now[static_cast<Index>(k)]));
      sum += shares[k] * slope;
    }
    const double least_off = std::max(off_sum / sum, 1e-4);
    VectorXf weights(now.size());
    VectorXf targets(now.size());
    for (std::size_t k = 0; k < shares.size(); ++k) {
      const double there = now[static_cast<Index>(k)];
      const double off = std::abs(logs_[k] - there);
      const double slope = std::max(std::abs(fitted_.means[k]), floor);
      const double error = std::abs(map.inverse(there) - fitted_.means[k]);
      const double secant = off > 1e-4 ? std::min(error / off, kSharpestSlope * slope) : slope;
      weights[static_cast<Index>(k)] = static_cast<float>(shares[k] * secant / std::max(off, least_off));
      targets[static_cast<Index>(k)] = static_cast<float>(logs_[k]);
    }
    add_squares(structure.fitted, weights, targets, problem.gram, problem.right);
  }
  problem.gram *= step * step;
  problem.right *= step;
  brdf.coefficients[0] = solve_integers(problem, brdf.coefficients[0]);
}

void SeriesProblem::fit_colours(const SeriesStructure& structure, SeriesBrdf& brdf, double price) const {
  const std::size_t channels = common_.channel_count();
  const std::size_t count = fitted_.means.size();
  const DomainMap<double> map(common_.domain(), 0);
  const VectorXf logs = field_at(structure.fitted, brdf, 0);
  std::vector<double> means(count);
  for (std::size_t k = 0; k < count; ++k) {
    means[k] = brdf.mean_of(map, static_cast<double>(logs[static_cast<Index>(k)]));
  }
  for (std::size_t j = 0; j < brdf.component_count; ++j) {
    std::vector<VectorXf> fields;
    for (std::size_t f = 1; f < brdf.field_count(); ++f) fields.push_back(field_at(structure.fitted, brdf, f));
    std::vector<double> left(count * channels);
    double off_sum = 0;
    double sum = 0;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const std::size_t pair = k / channels;
      double colour = brdf.mean_colour[k % channels] / kColourUnit;
      for (std::size_t f = 0; f < fields.size(); ++f) {
        colour += static_cast<double>(fields[f][static_cast<Index>(pair)]) * brdf.component(f, k % channels);
      }
      left[k] = fitted_.drawn.values[k] - means[pair] * colour;
      off_sum += fitted_.error_weights[k] * std::abs(left[k]);
      sum += fitted_.error_weights[k] * std::abs(means[pair]);
    }
    const double least_off = std::max(off_sum / sum, 1e-4);
    VectorXf weights = VectorXf::Zero(static_cast<Index>(count));
    VectorXf targets = VectorXf::Zero(static_cast<Index>(count));
    for (std::size_t k = 0; k < count; ++k) {
      double weight = 0;
      double right = 0;
      for (std::size_t c = 0; c < channels; ++c) {
        const double off = std::max(std::abs(left[k * channels + c]), least_off * std::abs(means[k]));
        if (!(off > 0)) continue;
        const double part = means[k] * brdf.component(j, c);
        const double each = fitted_.error_weights[k * channels + c] / off;
        weight += each * part * part;
        right += each * part * left[k * channels + c];
      }
      const double now = fields[j][static_cast<Index>(k)];
      weights[static_cast<Index>(k)] = static_cast<float>(weight);
      targets[static_cast<Index>(k)] = weight > 0 ? static_cast<float>(now + right / weight) : 0.0F;
    }
    IntegerProblem problem{{}, {}, price, first_bits(structure.basis)};
    add_squares(structure.fitted, weights, targets, problem.gram, problem.right);
    const double step = brdf.step();
    problem.gram *= step * step;
    problem.right *= step;
    brdf.coefficients[1 + j] = solve_integers(problem, brdf.coefficients[1 + j]);
  }
}

SeriesBrdf SeriesProblem::quantise(const SeriesStructure& structure, std::uint8_t step) const {
  SeriesBrdf brdf = common_;
  brdf.shape = structure.basis.shape;
  brdf.warp = structure.warp;
  brdf.coefficient_step = step;
  brdf.coefficients.assign(brdf.field_count(), std::vector<std::int32_t>(structure.basis.terms.size()));
  const double root = brdf.step() / kStepPerRootPrice;
  const double price = root * root;
  fit_first(structure, {}, brdf, price);
  fit_first(structure, field_at(structure.fitted, brdf, 0), brdf, price);
  if (brdf.component_count > 0) {
    fit_colours(structure, brdf, price);
    fit_colours(structure, brdf, price);
  }
  // Components without anything to say are left out.
  while (brdf.component_count > 0 &&
         std::all_of(brdf.coefficients.back().begin(), brdf.coefficients.back().end(), [](auto q) { return q == 0; })) {
    brdf.coefficients.pop_back();
    if (!brdf.components.empty()) brdf.components.pop_back();
    --brdf.component_count;
  }
  return brdf;
}

std::vector<float> SeriesProblem::judged_values(const SeriesStructure& structure, const SeriesBrdf& brdf) const {
  const MatrixXf& functions = structure.judged;
  const std::size_t channels = brdf.channel_count();
  std::vector<VectorXf> fields;
  for (std::size_t f = 0; f < brdf.field_count(); ++f) fields.push_back(field_at(functions, brdf, f));
  const DomainMap<double> map(brdf.domain(), 0);
  std::vector<float> values;
  for (Index k = 0; k < functions.rows(); ++k) {
    const double mean = brdf.mean_of(map, static_cast<double>(fields[0][k]));
    for (std::size_t c = 0; c < channels; ++c) {
      double colour = brdf.mean_colour[c] / kColourUnit;
      for (std::size_t j = 0; j < brdf.component_count; ++j) {
        colour += static_cast<double>(fields[1 + j][k]) * brdf.component(j, c);
      }
      values.push_back(static_cast<float>(brdf.negative ? mean * colour : std::max(mean * colour, 0.0)));
    }
  }
  return values;
}

}  // namespace sbrdf::internal
