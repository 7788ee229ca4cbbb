#include "codec/evaluation/tables/presample.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kMostHalvings = 10;  // of a bucket
constexpr std::uint64_t kPlaces = std::uint64_t{1} << 31U;

/// One curve of the exact form, at any place.
class Spline {
 public:
  Spline(const SliceTables& tables, const SliceTables::Line& line)
      : tables_(tables), channels_(tables.channels), knot_(tables.knot_buckets[line.first_bucket].knot) {
    for (std::size_t k = knot_; tables.places[k] != kBeyond; ++k) {
      for (std::size_t c = 0; c < channels_; ++c) largest_ = std::max(largest_, std::abs(double{row(k)[c]}));
    }
  }

  /// Places must not fall from call to call, but by `rewind`.
  void evaluate(std::uint64_t place, std::span<double> values) {
    while (static_cast<std::uint64_t>(tables_.places[knot_ + 1]) <= place) ++knot_;
    const double from = tables_.places[knot_];
    const double width = std::max(1.0, tables_.places[knot_ + 1] - from);
    const double t = std::min(1.0, (static_cast<double>(place) - from) / width);
    const double s = 1 - t;
    const double reach = s * t * width / double{kWidthUnit};
    const double far = t * t * (3 - 2 * t);
    const float* near_row = row(knot_);
    const float* far_row = row(knot_ + 1);
    for (std::size_t c = 0; c < channels_; ++c) {
      values[c] = (1 - far) * near_row[c] + far * far_row[c] +
                  reach * (s * near_row[channels_ + c] - t * far_row[channels_ + c]);
    }
  }

  [[nodiscard]] std::size_t knot() const { return knot_; }
  void rewind(std::size_t knot) { knot_ = knot; }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  [[nodiscard]] const float* row(std::size_t knot) const { return tables_.row_values.data() + knot * 2 * channels_; }

  const SliceTables& tables_;
  std::size_t channels_;
  std::size_t knot_;
  double largest_ = 0;
};

/// Fills the tables of the pre-sampled form.
class Presampler {
 public:
  Presampler(const SliceTables& exact, double tolerance, SliceTables& made)
      : exact_(exact), tolerance_(tolerance), made_(made), channels_(exact.channels) {}

  void make() {
    for (SliceTables::Line& line : made_.lines) {
      const std::uint32_t curve = line.first_bucket;
      const auto known = curves_.find(curve);
      line.first_bucket =
          known != curves_.end() ? known->second : curves_.emplace(curve, add_curve(line)).first->second;
    }
  }

 private:
  std::uint32_t add_curve(const SliceTables::Line& line) {
    const auto first_bucket = static_cast<std::uint32_t>(made_.row_buckets.size());
    const std::uint32_t bucket_shift = line.shape >> SliceTables::kBucketShift & 31U;
    Spline spline(exact_, line);
    std::vector<double> end;
    for (std::uint64_t from = 0; from < kPlaces; from += std::uint64_t{1} << bucket_shift) {
      const std::uint32_t step_shift = choose_step(spline, from, bucket_shift);
      const auto row = static_cast<std::uint32_t>(made_.row_values.size() / channels_);
      made_.row_buckets.push_back({row, step_shift});
      for (std::size_t k = 0; k + channels_ < samples_.size(); ++k) made_.row_values.push_back(samples_[k]);
      end.assign(samples_.end() - static_cast<std::ptrdiff_t>(channels_), samples_.end());
    }
    for (const double v : end) made_.row_values.push_back(static_cast<float>(v));
    return first_bucket;
  }

  // The longest step from row to row in a bucket with which the spline is met, whose rows `samples_` then holds. Beside
  // the rows each step is looked at three times.
  std::uint32_t choose_step(Spline& spline, std::uint64_t from, std::uint32_t bucket_shift) {
    const std::size_t knot = spline.knot();
    const std::uint32_t most = std::min(kMostHalvings, bucket_shift - std::min(bucket_shift, 2U));
    for (std::uint32_t halvings = 0;; ++halvings) {
      spline.rewind(knot);
      const std::uint32_t step_shift = bucket_shift - halvings;
      if (sample(spline, from, halvings, step_shift) || halvings >= most) return step_shift;
    }
  }

  bool sample(Spline& spline, std::uint64_t from, std::uint32_t halvings, std::uint32_t step_shift) {
    const std::size_t steps = std::size_t{1} << halvings;
    const std::uint64_t quarter = (std::uint64_t{1} << step_shift) / 4;
    samples_.clear();
    std::vector<double> values(5 * channels_);
    spline.evaluate(from, std::span(values).first(channels_));
    push(values);
    bool met = true;
    for (std::size_t step = 0; step < steps; ++step) {
      for (std::size_t q = 1; q <= 4; ++q) {
        const std::uint64_t place = std::min(from + (step * 4 + q) * std::max<std::uint64_t>(1, quarter), kPlaces - 2);
        spline.evaluate(place, std::span(values).subspan(q * channels_, channels_));
      }
      met = met && is_straight(values, spline.largest());
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(4 * channels_), channels_, values.begin());
      push(values);
    }
    return met;
  }

  void push(std::span<const double> values) {
    for (const double v : values.first(channels_)) samples_.push_back(static_cast<float>(v));
  }

  [[nodiscard]] bool is_straight(std::span<const double> values, double largest) const {
    for (std::size_t c = 0; c < channels_; ++c) {
      const double first = values[c];
      const double last = values[4 * channels_ + c];
      for (std::size_t q = 1; q < 4; ++q) {
        const double v = values[q * channels_ + c];
        const double scale = exact_.log ? 1 : std::max(std::abs(v), largest / 1000);
        if (std::abs(first + (last - first) * static_cast<double>(q) / 4 - v) > tolerance_ * scale) return false;
      }
    }
    return true;
  }

  const SliceTables& exact_;
  double tolerance_;
  SliceTables& made_;
  std::size_t channels_;
  std::map<std::uint32_t, std::uint32_t> curves_;  ///< first buckets, by those of the exact form
  std::vector<float> samples_;                     ///< rows of a bucket and the first one of the next
};

}  // namespace

SliceTables presample(const SliceTables& exact, double tolerance) {
  SliceTables made = exact;
  made.form = SliceTables::Form::kPresampled;
  made.row_size = static_cast<std::uint32_t>(exact.channels);
  made.places.clear();
  made.knot_buckets.clear();
  made.row_values.clear();
  Presampler(exact, tolerance, made).make();
  made.row_values.resize(made.row_values.size() + SliceTables::kLanes);
  return made;
}

}  // namespace sbrdf::internal
