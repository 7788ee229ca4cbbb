#include "converters/judge/compare.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "converters/source/reciprocity.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

// Blocks whose sums are held at a time, to be added up in their order. So little, that the memory is nothing, and the
// search for false values ends soon after enough were found.
constexpr std::uint64_t kWave = 64;
constexpr double kMinStep = 0.1;
constexpr std::uint64_t kMostPairs = 1ULL << 36U;     // a day's work
constexpr std::uint64_t kEnoughFalseValues = 10'000;  // by the strict count, after which no further wave is looked at
constexpr std::uint64_t kEnoughInBlock = 1'000;
constexpr double kMeanShare = 0.3;  // of the work, where the floor takes a pass over the reference

Status check(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options) {
  const auto usage = [](const char* what) { return usage_error(what); };
  if (!(options.step_deg >= kMinStep && options.step_deg <= 90)) return usage("the step must be in [0.1, 90] degrees");
  if (!(options.theta_max_deg >= 0 && options.theta_max_deg <= 90))
    return usage("theta-max must be in [0, 90] degrees");
  if (options.directions != CompareDirections::kGrid) {
    if (options.theta_max_deg == 0) return usage("random directions need a theta-max above 0 degrees");
    if (options.random_count == 0) return usage("the number of random directions must not be 0");
  }
  if (options.floor && !(*options.floor >= 0 && std::isfinite(*options.floor))) {
    return usage("the floor must be finite and not negative");
  }
  if (reference.channel_count() != test.channel_count()) {
    return unsupported("the reference has " + std::to_string(reference.channel_count()) + " channels, the test " +
                       std::to_string(test.channel_count()));
  }
  return ok_status();
}

/// The vectors of directions one after the other, most of which share an angle with the one before.
class VectorOf {
 public:
  glm::vec3 operator()(const Direction& direction) {
    if (direction.theta != theta_) {
      theta_ = direction.theta;
      sin_theta_ = std::sin(theta_);
      cos_theta_ = std::cos(theta_);
    }
    if (direction.phi != phi_) {
      phi_ = direction.phi;
      sin_phi_ = std::sin(phi_);
      cos_phi_ = std::cos(phi_);
    }
    return {sin_theta_ * cos_phi_, sin_theta_ * sin_phi_, cos_theta_};
  }

 private:
  double theta_ = 0, sin_theta_ = 0, cos_theta_ = 1;
  double phi_ = 0, sin_phi_ = 0, cos_phi_ = 1;
};

/// Pairs as sources are asked for them: all by their angles, or all by vectors.
class Asked {
 public:
  Asked(std::span<const WeightedPair> weighted, bool by_vectors) : by_vectors_(by_vectors) {
    VectorOf vector_i;
    VectorOf vector_v;
    for (const auto& [pair, weight] : weighted) {
      if (by_vectors) {
        w_i_.push_back(vector_i(pair.i));
        w_v_.push_back(vector_v(pair.v));
      } else {
        pairs_.push_back(pair);
      }
    }
  }

  [[nodiscard]] std::vector<float> values_of(const BrdfSource& source) const {
    std::vector<float> values((by_vectors_ ? w_i_.size() : pairs_.size()) * source.channel_count());
    if (by_vectors_) {
      source.evaluate_vectors(w_i_, w_v_, values);
    } else {
      source.evaluate(pairs_, values);
    }
    return values;
  }

 private:
  bool by_vectors_;
  std::vector<DirectionPair> pairs_;
  std::vector<glm::vec3> w_i_;
  std::vector<glm::vec3> w_v_;
};

class Comparer {
 public:
  Comparer(const BrdfSource& reference, const BrdfSource& test, const ComparedPairs& pairs,
           FalseValueSearch false_values)
      : reference_(reference),
        test_(test),
        pairs_(pairs),
        false_values_(false_values),
        channels_(reference.channel_count()),
        by_vectors_(reference.sliced() != nullptr || test.sliced() != nullptr) {}

  /// A hundredth of the mean |f|.
  Result<double> floor_of_draw(const Progress& progress) const {
    struct Mean {
      double sum = 0;
      double weight = 0;
    };
    Mean all;
    const bool done = in_waves<Mean>(
        progress, {},
        [&](std::uint64_t block, Mean& mean) {
          const std::vector<WeightedPair> pairs = measured_pairs(block);
          const std::vector<float> f = Asked(pairs, by_vectors_).values_of(reference_);
          for (std::size_t k = 0; k < f.size(); ++k) {
            const double weight = pairs[k / channels_].weight;
            mean.sum += weight * std::abs(static_cast<double>(f[k]));
            mean.weight += weight;
          }
        },
        [&](const Mean& mean) {
          all.sum += mean.sum;
          all.weight += mean.weight;
        });
    if (!done) return interrupted_error();
    return 0.01 * all.sum / all.weight;
  }

  Result<Comparison> compare(double floor, const Progress& progress) const {
    struct Block {
      ChannelErrors errors;
      FalseValues false_values;
      std::uint64_t measured = 0;
    };
    std::uint64_t measured = 0;
    ChannelErrors errors(channels_, floor);
    FalseValues false_values;
    false_values.complete = looks_for_them();
    std::vector<LogHistogram> relative(channels_);
    std::mutex mutex;  // of `relative`, to which the order of adding makes no difference
    const bool done = in_waves<Block>(
        progress, {ChannelErrors(channels_, floor), {}, 0},
        [&](std::uint64_t block, Block& own) {
          std::vector<LogHistogram> own_relative(channels_);
          own.false_values.complete = looks_for_them() && found_in(false_values) < kEnoughFalseValues;
          own.measured = compare_block(block, own.errors, own_relative, own.false_values);
          const std::scoped_lock lock(mutex);
          for (std::size_t c = 0; c < channels_; ++c) relative[c].add(own_relative[c]);
        },
        [&](const Block& block) {
          errors.add(block.errors);
          false_values.add(block.false_values);
          measured += block.measured;
        });
    if (!done) return interrupted_error();
    if (measured == 0) return usage_error("reference and test have measured none of these directions both");
    Comparison result{errors.all(relative),     errors.channels(relative), false_values, floor, measured,
                      pairs_.size() - measured, pairs_.stands_for()};
    return result;
  }

 private:
  [[nodiscard]] bool looks_for_them() const { return false_values_ != FalseValueSearch::kNone; }
  [[nodiscard]] static std::uint64_t found_in(const FalseValues& found) {
    return std::max(found.count, found.strict_count());
  }

  // Calls `work` for all blocks, some at a time, and hands what each has made to `take` in the order of the blocks.
  // False where it was stopped.
  template <class Own, class Work, class Take>
  bool in_waves(const Progress& progress, const Own& empty, const Work& work, const Take& take) const {
    const std::uint64_t blocks = pairs_.block_count();
    ProgressCounter counter(progress, blocks);
    for (std::uint64_t first = 0; first < blocks && !counter.stopped(); first += kWave) {
      std::vector<Own> own(std::min(kWave, blocks - first), empty);
      parallel_for(own.size(), [&](std::uint64_t k) {
        if (counter.stopped()) return;
        work(first + k, own[k]);
        counter.advance();
      });
      std::for_each(own.begin(), own.end(), take);
    }
    return !counter.stopped();
  }

  // Of a block, those that both measured.
  std::vector<WeightedPair> measured_pairs(std::uint64_t block) const {
    std::vector<WeightedPair> left = pairs_.block(block);
    for (const BrdfSource* source : {&reference_, &test_}) {
      if (!source->mask_grid()) continue;
      std::vector<DirectionPair> pairs;
      for (const WeightedPair& at : left) pairs.push_back(at.pair);
      std::vector<std::uint8_t> flags(pairs.size());
      source->measured(pairs, flags);
      std::vector<WeightedPair> measured;
      for (std::size_t k = 0; k < left.size(); ++k) {
        if (flags[k] == 1) measured.push_back(left[k]);
      }
      left = std::move(measured);
    }
    return left;
  }

  // How many pairs were measured.
  std::uint64_t compare_block(std::uint64_t block, ChannelErrors& errors, std::span<LogHistogram> relative,
                              FalseValues& false_values) const {
    const std::vector<WeightedPair> pairs = measured_pairs(block);
    const Asked asked(pairs, by_vectors_);
    const std::vector<float> f = asked.values_of(reference_);
    const std::vector<float> r = asked.values_of(test_);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto of_pair = [&](const std::vector<float>& values) {
        return std::span(values).subspan(k * channels_, channels_);
      };
      errors.add(pairs[k], of_pair(f), of_pair(r), relative);
      if (found_in(false_values) >= kEnoughInBlock) false_values.complete = false;
      if (!false_values.complete) continue;
      find_false_values(reference_, pairs[k].pair, of_pair(f), of_pair(r), false_values_, false_values);
    }
    return pairs.size();
  }

  const BrdfSource& reference_;
  const BrdfSource& test_;
  const ComparedPairs& pairs_;
  FalseValueSearch false_values_;
  std::size_t channels_;
  bool by_vectors_;  ///< slices are evaluated faster from these
};

}  // namespace

Result<Comparison> compare_sources(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options,
                                   const Progress& progress) {
  if (Status status = check(reference, test, options); !status) return status.error();
  std::optional<SymmetrisedSource> symmetrised;
  if (options.symmetrise) symmetrised.emplace(reference);
  const BrdfSource& judge = symmetrised ? static_cast<const BrdfSource&>(*symmetrised) : reference;
  const ComparedPairs pairs(options, reference.traits().isotropic && test.traits().isotropic);
  if (pairs.size() > kMostPairs) {
    return usage_error(std::to_string(pairs.size()) + " direction pairs are too many; take a larger step");
  }
  const Comparer comparer(judge, test, pairs, options.false_values);
  if (options.floor) return comparer.compare(*options.floor, progress);
  if (options.directions == CompareDirections::kGrid) return comparer.compare(0, progress);
  StepwiseProgress steps(progress);
  const Result<double> floor = comparer.floor_of_draw(steps.step(kMeanShare));
  if (!floor) return floor.error();
  return comparer.compare(*floor, steps.step(1));
}

}  // namespace sbrdf::internal
