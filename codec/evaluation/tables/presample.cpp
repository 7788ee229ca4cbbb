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

/// One curve of the exact form, at places that rise. Beyond its last knot it holds.
class Spline {
 public:
  Spline(const SliceTables& tables, const SliceTables::Line& line)
      : tables_(tables), channels_(tables.channels), knot_(tables.knot_buckets[line.first_bucket].knot) {
    for (last_ = knot_; tables.places[last_ + 1] != kBeyond; ++last_) {
    }
    for (std::size_t k = knot_; k <= last_; ++k) {
      for (std::size_t c = 0; c < channels_; ++c) largest_ = std::max(largest_, std::abs(double{row(k)[c]}));
    }
  }

  [[nodiscard]] std::uint64_t last_place() const { return static_cast<std::uint64_t>(tables_.places[last_]); }
  [[nodiscard]] double largest() const { return largest_; }

  void evaluate(std::uint64_t place, std::span<double> values) {
    while (knot_ < last_ && static_cast<std::uint64_t>(tables_.places[knot_ + 1]) <= place) ++knot_;
    const float* near_row = row(knot_);
    if (knot_ == last_) {
      std::copy_n(near_row, channels_, values.begin());
      return;
    }
    const double from = tables_.places[knot_];
    const double width = std::max(1.0, tables_.places[knot_ + 1] - from);
    const double t = (static_cast<double>(place) - from) / width;
    const double s = 1 - t;
    const double reach = s * t * width / double{kWidthUnit};
    const double far = t * t * (3 - 2 * t);
    const float* far_row = row(knot_ + 1);
    for (std::size_t c = 0; c < channels_; ++c) {
      values[c] = (1 - far) * near_row[c] + far * far_row[c] +
                  reach * (s * near_row[channels_ + c] - t * far_row[channels_ + c]);
    }
  }

  /// Adds the places of knots behind the one that was passed last, before `end`.
  void add_knots_before(std::uint64_t end, std::vector<std::uint64_t>& places) const {
    for (std::size_t k = knot_ + 1; k <= last_ && static_cast<std::uint64_t>(tables_.places[k]) < end; ++k) {
      places.push_back(static_cast<std::uint64_t>(tables_.places[k]));
    }
  }

  [[nodiscard]] std::size_t knot() const { return knot_; }
  void rewind(std::size_t knot) { knot_ = knot; }

 private:
  [[nodiscard]] const float* row(std::size_t knot) const { return tables_.row_values.data() + knot * 2 * channels_; }

  const SliceTables& tables_;
  std::size_t channels_;
  std::size_t knot_;
  std::size_t last_ = 0;
  double largest_ = 0;
};

/// Fills the tables of the pre-sampled form.
class Presampler {
 public:
  Presampler(const SliceTables& exact, double tolerance, SliceTables& made)
      : exact_(exact),
        tolerance_(tolerance),
        made_(made),
        channels_(exact.channels),
        first_(channels_),
        last_(channels_) {}

  void make() {
    for (std::size_t number = 0; number <= exact_.lattice->line_count; ++number) {
      SliceTables::Line& line = made_.lines[number];
      const std::uint32_t curve = line.first_bucket;
      auto known = curves_.find(curve);
      if (known == curves_.end()) {
        // Nobody goes beyond the end of a slice; of a guide they do.
        known = curves_.emplace(curve, add_curve(line, number == exact_.lattice->line_count)).first;
      }
      line.first_bucket = known->second;
    }
  }

 private:
  std::uint32_t add_curve(const SliceTables::Line& line, bool to_the_end) {
    const auto first_bucket = static_cast<std::uint32_t>(made_.row_buckets.size());
    const std::uint32_t bucket_shift = line.shape >> SliceTables::kBucketShift & 31U;
    Spline spline(exact_, line);
    const std::uint64_t last = to_the_end ? kPlaces - 1 : spline.last_place();
    for (std::uint64_t from = 0; from <= last; from += std::uint64_t{1} << bucket_shift) {
      const std::uint32_t step_shift = choose_step(spline, from, bucket_shift);
      const auto row = static_cast<std::uint32_t>(made_.row_values.size() / channels_);
      made_.row_buckets.push_back({row, step_shift});
      made_.row_values.insert(made_.row_values.end(), samples_.begin(),
                              samples_.end() - static_cast<std::ptrdiff_t>(channels_));
    }
    for (const double v : last_) made_.row_values.push_back(static_cast<float>(v));
    return first_bucket;
  }

  // The longest step from row to row in a bucket with which the spline is met, whose rows and the next one's first
  // `samples_` then holds. Beside the rows each step is looked at in three places, and at the knots in it.
  std::uint32_t choose_step(Spline& spline, std::uint64_t from, std::uint32_t bucket_shift) {
    const std::size_t knot = spline.knot();
    const std::uint32_t most = std::min(kMostHalvings, bucket_shift - std::min(bucket_shift, 2U));
    for (std::uint32_t halvings = 0;; ++halvings) {
      spline.rewind(knot);
      if (sample(spline, from, halvings, bucket_shift - halvings) || halvings >= most) return bucket_shift - halvings;
    }
  }

  bool sample(Spline& spline, std::uint64_t from, std::uint32_t halvings, std::uint32_t step_shift) {
    const std::uint64_t width = std::uint64_t{1} << step_shift;
    samples_.clear();
    spline.evaluate(from, last_);
    push(last_);
    bool met = true;
    for (std::uint64_t step = 0; step < std::uint64_t{1} << halvings; ++step) {
      const std::uint64_t begin = from + step * width;
      first_ = last_;
      places_.clear();
      for (std::uint64_t quarter = 1; quarter < 4 && width >= 4; ++quarter)
        places_.push_back(begin + quarter * width / 4);
      spline.add_knots_before(begin + width, places_);
      std::sort(places_.begin(), places_.end());
      inner_.resize(places_.size() * channels_);
      for (std::size_t k = 0; k < places_.size(); ++k) {
        spline.evaluate(places_[k], std::span(inner_).subspan(k * channels_, channels_));
      }
      spline.evaluate(begin + width, last_);
      push(last_);
      met = met && is_straight(begin, width, spline.largest());
    }
    return met;
  }

  void push(std::span<const double> values) {
    for (const double v : values) samples_.push_back(static_cast<float>(v));
  }

  // A difference that is no number is none that is small.
  [[nodiscard]] bool is_straight(std::uint64_t begin, std::uint64_t width, double largest) const {
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const double t = static_cast<double>(places_[k] - begin) / static_cast<double>(width);
      for (std::size_t c = 0; c < channels_; ++c) {
        const double v = inner_[k * channels_ + c];
        const double scale = exact_.log ? 1 : std::max(std::abs(v), largest / 1000);
        if (!(std::abs(first_[c] + (last_[c] - first_[c]) * t - v) <= tolerance_ * scale)) return false;
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
  std::vector<double> first_;                      ///< values at both ends of a step, and at places between
  std::vector<double> last_;
  std::vector<std::uint64_t> places_;
  std::vector<double> inner_;
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
