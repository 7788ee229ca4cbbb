#include "codec/sampling/guide_fit.h"

#include <algorithm>
#include <cmath>

#include "codec/material/value_map.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMaxAzimuths = 12;  // of each azimuthal axis, evenly picked
constexpr double kSmallestGapDeg = 0.05;  // of the guide's angle
constexpr double kLeastError = 1e-3;      // in the value domain; below this a guide has done its work

std::vector<double> pick(const std::vector<double>& nodes) {
  if (nodes.size() <= kMaxAzimuths) return nodes;
  std::vector<double> picked;
  for (std::size_t k = 0; k < kMaxAzimuths; ++k) picked.push_back(nodes[k * nodes.size() / kMaxAzimuths]);
  return picked;
}

class GuideFit {
 public:
  GuideFit(const SlicedBrdf& sliced, const Lattice& lattice, double ratio, const Measure& measure)
      : spec_(lattice.spec), nodes_(lattice.nodes[kVertical]), channels_(sliced.channel_count()), measure_(measure) {
    guide_.ratio = ratio;
    for (std::size_t c = 0; c < channels_; ++c) maps_.emplace_back(sliced.domain, c);
    for (const double phi_h : pick(lattice.spec.axes[kAxial].nodes_deg)) {
      for (const double phi_d : pick(lattice.spec.axes[kDiagonal].nodes_deg)) {
        for (const double theta_d : lattice.spec.axes[kHorizontal].nodes_deg)
          rays_.push_back({phi_h, phi_d, theta_d, 0});
      }
    }
  }

  Result<Guide> run(std::size_t sample_count) {
    std::vector<float> means;
    for (std::uint32_t k = 0; k < nodes_.size(); ++k) {
      if (Status status = profile(nodes_[k], means); !status) return status.error();
      insert(guide_.places.size(), {k, 0}, means);
    }
    for (std::size_t gap = 0; gap + 1 < guide_.places.size(); ++gap) {
      if (Status status = probe(gap); !status) return status.error();
    }
    while (guide_.places.size() < sample_count) {
      const std::size_t gap = worst_gap();
      if (gap == gaps_.size()) break;
      const Probe chosen = gaps_[gap];
      insert(gap + 1, chosen.place, chosen.means);
      gaps_.erase(gaps_.begin() + static_cast<std::ptrdiff_t>(gap));
      for (const std::size_t child : {gap, gap + 1}) {
        if (Status status = probe(child); !status) return status.error();
      }
    }
    return guide_;
  }

 private:
  struct Probe {  ///< the source half way between two samples
    SamplePosition place;
    std::vector<float> means;
  };

  // The mean along all rays at one angle of the guide; rays below the horizon do not count.
  Status profile(double angle_deg, std::vector<float>& means) {
    std::vector<DirectionPair> pairs;
    for (Coordinates x : rays_) {
      x[kVertical] = theta_h_deg(x[kAxial], angle_deg);
      const DirectionPair pair = directions_at(spec_, x);
      const double limit = radians_from_degrees(ease_from_deg(spec_.theta_max_deg) + 0.5);
      if (pair.i.theta <= limit && pair.v.theta <= limit) pairs.push_back(pair);
    }
    means.assign(channels_, 0);
    if (pairs.empty()) {
      if (!guide_.values.empty())
        means.assign(guide_.values.end() - static_cast<std::ptrdiff_t>(channels_), guide_.values.end());
      return ok_status();
    }
    std::vector<float> values(pairs.size() * channels_);
    if (Status status = measure_(pairs, values); !status) return status;
    for (std::size_t c = 0; c < channels_; ++c) {
      double sum = 0;
      for (std::size_t k = 0; k < pairs.size(); ++k) sum += maps_[c].forward(values[k * channels_ + c]);
      means[c] = static_cast<float>(sum / static_cast<double>(pairs.size()));
    }
    return ok_status();
  }

  // The inverse of guide_angle_deg: the tangents have a ratio that depends on phi_h alone, found where tan(theta_h)
  // = 1.
  [[nodiscard]] double theta_h_deg(double phi_h_deg, double angle_deg) const {
    const double at_45 = guide_angle_deg(guide_.ratio, {phi_h_deg, 0, 0, 45});
    const double scale = std::tan(radians_from_degrees(at_45));
    return std::min(90.0, degrees_from_radians(std::atan(std::tan(radians_from_degrees(angle_deg)) / scale)));
  }

  void insert(std::size_t at, const SamplePosition& place, const std::vector<float>& means) {
    guide_.places.insert(guide_.places.begin() + static_cast<std::ptrdiff_t>(at), place);
    guide_.values.insert(guide_.values.begin() + static_cast<std::ptrdiff_t>(at * channels_), means.begin(),
                         means.end());
  }

  Status probe(std::size_t gap) {
    const SamplePosition& left = guide_.places[gap];
    const SamplePosition& right = guide_.places[gap + 1];
    const std::uint32_t end = right.interval == left.interval ? right.fraction : SamplePosition::kOne;
    Probe probe;
    probe.place = {left.interval, (left.fraction + end) / 2};
    const double width = guide_position_deg(nodes_, right) - guide_position_deg(nodes_, left);
    if (width < 2 * kSmallestGapDeg || end - left.fraction < 2) {
      probe.place.fraction = 0;
    } else if (Status status = profile(guide_position_deg(nodes_, probe.place), probe.means); !status) {
      return status;
    }
    gaps_.insert(gaps_.begin() + static_cast<std::ptrdiff_t>(gap), std::move(probe));
    return ok_status();
  }

  [[nodiscard]] std::size_t worst_gap() const {
    const GuideCurve<double> curve(guide_, nodes_, channels_);
    std::size_t worst = gaps_.size();
    double error = kLeastError;
    std::vector<double> values(channels_);
    for (std::size_t gap = 0; gap < gaps_.size(); ++gap) {
      if (gaps_[gap].place.fraction == 0) continue;
      curve.evaluate_at(guide_position_deg(nodes_, gaps_[gap].place), 0, values);
      double difference = 0;
      for (std::size_t c = 0; c < channels_; ++c)
        difference = std::max(difference, std::abs(values[c] - gaps_[gap].means[c]));
      if (difference > error) {
        error = difference;
        worst = gap;
      }
    }
    return worst;
  }

  const FrameSpec& spec_;
  const std::vector<double>& nodes_;
  std::size_t channels_;
  const Measure& measure_;
  std::vector<DomainMap<double>> maps_;
  std::vector<Coordinates> rays_;
  Guide guide_;
  std::vector<Probe> gaps_;
};

}  // namespace

Result<Guide> fit_guide(const SlicedBrdf& sliced, const Lattice& lattice, double ratio, std::size_t sample_count,
                        const Measure& measure) {
  return GuideFit(sliced, lattice, ratio, measure).run(sample_count);
}

}  // namespace sbrdf::internal
