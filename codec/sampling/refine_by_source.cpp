#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "codec/curves/spline.h"
#include "codec/sampling/sampler.h"

namespace sbrdf::internal {
namespace {

/// A gap weighs the error of the spline within it, times its width and the share of all directions that its slice
/// serves:
///
///   weight = width x share x sum over probes and channels of |spline - v| |f|^p
///
/// Three probes of the source stand in each gap, at its quarters. Halving a gap makes its middle probe a sample and the
/// other two the middle probes of its halves, so each sample costs four new probes, and none is measured twice:
///
///   left     0     1     2     right          the gap, its probes 0, 1, 2
///   left  0  1  2 new 0  1  2  right          its halves; both their 1 were there before
class RefineBySource final : public Sampler {
 public:
  using Sampler::Sampler;

 private:
  static constexpr std::size_t kProbes = 3;
  static constexpr std::size_t kMiddle = 1;
  static constexpr std::array<std::size_t, 2> kFresh = {0, 2};  // what a half has to measure

  // What is known of a probe: v there and the weight of an error, both for each channel. Kept, since each round weighs
  // the gaps of a slice anew.
  using Rows = std::vector<double>;

  Status start() override {
    for (std::size_t c = 0; c < channels_ && sliced_.domain.kind == DomainKind::kLog; ++c) {
      floors_.push_back(sliced_.domain.floor(c));
    }
    std::vector<std::size_t> first_rows = {0};  // of each slice, and one more: the end
    for (std::uint32_t k = 0; k < slices_.size(); ++k) {
      first_rows.push_back(first_rows.back() + gap_count(lattice_.slices[k], slices_[k].samples) * kProbes);
    }
    std::vector<Coordinates> places(first_rows.back());
    volume_.resize(slices_.size());
    judged_.resize(slices_.size());
    for_all(slices_.size(), kSlicesPerTask, [&](std::size_t number) {
      const auto k = static_cast<std::uint32_t>(number);
      volume_[k] = volume_served(lattice_.slices[k]);
      map_.forward(lattice_.slices[k], slices_[k].samples, slices_[k].mapped);
      for (std::size_t row = first_rows[k]; row < first_rows[k + 1]; ++row) {
        const std::size_t probe = row - first_rows[k];
        places[row] = probe_at(k, probe / kProbes, probe % kProbes);
      }
    });
    std::vector<float> values;
    Rows judged;
    if (Status status = look(places, values, judged); !status) return status;
    for_all(slices_.size(), kSlicesPerTask, [&](std::size_t number) {
      const auto k = static_cast<std::uint32_t>(number);
      const std::size_t rows = first_rows[k + 1] - first_rows[k];
      append_rows<float>(values, channels_, first_rows[k], rows, slices_[k].probes);
      append_rows<double>(judged, 2 * channels_, first_rows[k], rows, judged_[k]);
      weigh(k);
    });
    return ok_status();
  }

  // Each round places a part of what is left, so that later ones see the splines that earlier ones made.
  std::uint64_t target_after(int /*round*/, std::uint64_t adaptive) const override {
    const std::uint64_t left = adaptive - placed_;
    return placed_ + std::min(left, std::max<std::uint64_t>(left / options_.rounds_divisor, 1 + adaptive / 100));
  }

  // The middle probe of a gap is the new sample.
  Status measure_middles(std::span<const Candidate> chosen, std::vector<float>& values) override {
    for (const Candidate& candidate : chosen) {
      append_rows<float>(slices_[candidate.slice].probes, channels_, probe_row(candidate.left, kMiddle), 1, values);
    }
    return ok_status();
  }

  Status refresh(std::span<const Candidate> chosen) override {
    constexpr std::size_t kProbesOfHalves = 2 * kFresh.size();
    std::vector<Coordinates> places(chosen.size() * kProbesOfHalves);
    for_each_slice(chosen, [&](std::span<const Candidate> run, std::size_t first) {
      std::size_t row = first * kProbesOfHalves;
      for (std::size_t k = 0; k < run.size(); ++k) {
        const std::size_t left = run[k].left + k;  // each half made before moved it up by one
        for (const std::size_t half : {left, left + 1}) {
          for (const std::size_t probe : kFresh) places[row++] = probe_at(run[k].slice, half, probe);
        }
      }
    });
    std::vector<float> values;
    Rows judged;
    if (Status status = look(places, values, judged); !status) return status;
    for_each_slice(chosen, [&](std::span<const Candidate> run, std::size_t first) {
      const std::uint32_t k = run.front().slice;
      const std::size_t row = first * kProbesOfHalves;
      add_middles(run);
      split_probes<float>(run, values, channels_, row, slices_[k].probes);
      split_probes<double>(run, judged, 2 * channels_, row, judged_[k]);
      weigh(k);
    });
    return ok_status();
  }

  // The source at some places, and what is kept of it.
  Status look(std::span<const Coordinates> places, std::vector<float>& values, Rows& judged) {
    std::vector<DirectionPair> pairs(places.size());
    for_all(places.size(), kPairsPerTask, [&](std::size_t k) { pairs[k] = directions_at(lattice_.spec, places[k]); });
    values.resize(pairs.size() * channels_);
    if (Status status = measure_(pairs, values); !status) return status;
    judged.resize(2 * values.size());
    for_all(places.size(), kPairsPerTask, [&](std::size_t k) {
      const auto f = std::span<const float>(values).subspan(k * channels_, channels_);
      const auto row = std::span(judged).subspan(2 * k * channels_, 2 * channels_);
      map_.forward(places[k], f, row.first(channels_));
      for (std::size_t c = 0; c < channels_; ++c) row[channels_ + c] = value_weight(c, f[c]);
    });
    return ok_status();
  }

  // Rows of a table with `width` values each.
  template <class T>
  static void append_rows(std::span<const T> from, std::size_t width, std::size_t row, std::size_t count,
                          std::vector<T>& to) {
    const auto rows = from.subspan(row * width, count * width);
    to.insert(to.end(), rows.begin(), rows.end());
  }

  /// Of Working::probes.
  [[nodiscard]] static std::size_t probe_row(std::size_t gap, std::size_t probe) { return gap * kProbes + probe; }

  // What the new samples of a slice hold is known from the middle probes that they were.
  void add_middles(std::span<const Candidate> chosen) {
    Working& working = slices_[chosen.front().slice];
    const Rows& judged = judged_[chosen.front().slice];
    Rows next;
    next.reserve(working.mapped.size() + chosen.size() * channels_);
    std::size_t sample = 0;
    for (const Candidate& candidate : chosen) {
      append_rows<double>(working.mapped, channels_, sample, candidate.left + 1 - sample, next);
      append_rows<double>(judged, channels_, 2 * probe_row(candidate.left, kMiddle), 1, next);
      sample = candidate.left + 1;
    }
    append_rows<double>(working.mapped, channels_, sample, working.mapped.size() / channels_ - sample, next);
    working.mapped = std::move(next);
  }

  // Makes two gaps of each chosen one of a slice. `fresh` has, from `row` on, two probes for each half.
  template <class T>
  static void split_probes(std::span<const Candidate> chosen, std::span<const T> fresh, std::size_t width,
                           std::size_t row, std::vector<T>& probes) {
    std::vector<T> next;
    next.reserve(probes.size() + chosen.size() * kProbes * width);
    std::size_t gap = 0;
    for (const Candidate& candidate : chosen) {
      append_rows<T>(probes, width, probe_row(gap, 0), (candidate.left - gap) * kProbes, next);
      for (const std::size_t old_probe : kFresh) {
        append_rows<T>(fresh, width, row++, 1, next);
        append_rows<T>(probes, width, probe_row(candidate.left, old_probe), 1, next);
        append_rows<T>(fresh, width, row++, 1, next);
      }
      gap = candidate.left + 1;
    }
    append_rows<T>(probes, width, probe_row(gap, 0), probes.size() / width - probe_row(gap, 0), next);
    probes = std::move(next);
  }

  [[nodiscard]] static double probe_fraction(std::size_t probe) { return static_cast<double>(probe + 1) / 4; }

  [[nodiscard]] Coordinates probe_at(std::uint32_t k, std::size_t left, std::size_t probe) const {
    const Slice& slice = lattice_.slices[k];
    const SliceSamples& samples = slices_[k].samples;
    const double width = gap_after(lattice_, slice, samples, left).width_deg;
    const double position = samples.positions_deg[left] + probe_fraction(probe) * width;
    return coordinates_on(slice, position);
  }

  void weigh(std::uint32_t k) {
    Working& working = slices_[k];
    const Slice& slice = lattice_.slices[k];
    SplineSolver<double> solver;
    Rows second(working.mapped.size());
    for (std::size_t c = 0; c < channels_; ++c) {
      solver.solve(slice.boundary, slice.length_deg, working.samples.positions_deg, working.mapped.data() + c,
                   second.data() + c, channels_);
    }
    const std::size_t n = working.samples.size();
    working.weights.assign(gap_count(slice, working.samples), -1);
    for (std::size_t left = 0; left < working.weights.size(); ++left) {
      const Gap gap = gap_after(lattice_, slice, working.samples, left);
      if (!may_split(slice, gap)) continue;
      working.weights[left] =
          error_in_gap(k, left, left + 1 < n ? left + 1 : 0, gap.width_deg, second) * gap.width_deg * volume_[k];
    }
  }

  [[nodiscard]] double error_in_gap(std::uint32_t k, std::size_t left, std::size_t right, double width,
                                    const Rows& second) const {
    const std::vector<double>& mapped = slices_[k].mapped;
    double sum = 0;
    for (std::size_t p = 0; p < kProbes; ++p) {
      const double t = probe_fraction(p);
      const double* judged = judged_[k].data() + probe_row(left, p) * 2 * channels_;
      for (std::size_t c = 0; c < channels_; ++c) {
        const double spline =
            evaluate_segment(t, width * width / 6, mapped[left * channels_ + c], mapped[right * channels_ + c],
                             second[left * channels_ + c], second[right * channels_ + c]);
        sum += std::abs(spline - judged[c]) * judged[channels_ + c];
      }
    }
    return sum;
  }

  // An error in the log domain is relative: f times as large in f_r.
  [[nodiscard]] double value_weight(std::size_t c, float f) const {
    const bool log = sliced_.domain.kind == DomainKind::kLog;
    const double least = log ? floors_[c] : 1e-9;
    return power(std::max<double>(std::abs(f), least), options_.value_exponent - (log ? 0 : 1));
  }

  // Searches take one of five exponents; std::pow takes longer than all the rest of a probe.
  [[nodiscard]] static double power(double f, double exponent) {
    if (exponent == 0) return 1;
    if (exponent == 0.5) return std::sqrt(f);
    if (exponent == -0.5) return 1 / std::sqrt(f);
    if (exponent == 1) return f;
    if (exponent == -1) return 1 / f;
    return std::pow(f, exponent);
  }

  // Half the neighbouring cells on each other axis, times how dense directions lie there.
  [[nodiscard]] double volume_served(const Slice& slice) const {
    double volume = 1;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double>& nodes = lattice_.nodes[axis];
      if (axis == slice.kind || nodes.size() < 2) continue;
      volume *= frame_.share_served(axis, nodes, slice.fixed[axis]);
    }
    return volume;
  }

  std::vector<double> floors_;  ///< of the log domain, per channel
  std::vector<double> volume_;  ///< per slice
  std::vector<Rows> judged_;    ///< per slice: a row for each probe, of v and of weights
};

}  // namespace

Status sample_by_true_error(const Lattice& lattice, const Measure& measure, const SamplingOptions& options,
                            SlicedBrdf& sliced) {
  return RefineBySource(lattice, measure, options, sliced).run();
}

}  // namespace sbrdf::internal
