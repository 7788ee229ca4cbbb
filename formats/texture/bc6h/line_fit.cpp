#include "formats/texture/bc6h/line_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sbrdf::internal {

namespace {

using Vector = std::array<float, 3>;

// Sums over texels: weight, R, G, B, then RR, RG, RB, GG, GB, BB; two more so that loops take four at a time.
using Moments = std::array<float, 12>;

// A symmetric matrix: RR, RG, RB, GG, GB, BB.
using Symmetric = std::array<float, 6>;

// What channels are multiplied by so that differences in them weigh alike, and what texels weigh then.
struct Space {
  Vector centre{};
  Vector scale{};
  Bc6hRow weight{};
};

Space make_space(const Bc6hRegion& region) {
  Space space;
  Vector total{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t at = 0; at < region.size; ++at) {
      const float weight = region.fit_weight[c][at];
      space.centre[c] += weight * region.mixed[c][at];
      space.weight[at] += weight / 3;
      total[c] += weight;
    }
  }
  const float mean = (total[0] + total[1] + total[2]) / 3;
  if (!(mean > 0)) return {};
  for (std::size_t c = 0; c < 3; ++c) {
    space.centre[c] /= total[c];
    space.scale[c] = std::sqrt(total[c] / mean);
  }
  return space;
}

Vector place(const Bc6hRegion& region, const Space& space, std::size_t at) {
  Vector x{};
  for (std::size_t c = 0; c < 3; ++c) x[c] = (region.mixed[c][at] - space.centre[c]) * space.scale[c];
  return x;
}

Moments moments_of(const Vector& x, float weight) {
  const Vector y = {weight * x[0], weight * x[1], weight * x[2]};
  return {weight, y[0], y[1], y[2], y[0] * x[0], y[0] * x[1], y[0] * x[2], y[1] * x[1], y[1] * x[2], y[2] * x[2]};
}

void add(Moments& sum, const Moments& more) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += more[k];
}

// Sums of squares about the mean.
Symmetric scatter_of(const Moments& m) {
  const float share = m[0] > 0 ? 1 / m[0] : 0.0F;
  return {m[4] - m[1] * m[1] * share, m[5] - m[1] * m[2] * share, m[6] - m[1] * m[3] * share,
          m[7] - m[2] * m[2] * share, m[8] - m[2] * m[3] * share, m[9] - m[3] * m[3] * share};
}

float trace(const Symmetric& s) { return s[0] + s[3] + s[5]; }

Symmetric squared(const Symmetric& s) {
  return {s[0] * s[0] + s[1] * s[1] + s[2] * s[2], s[0] * s[1] + s[1] * s[3] + s[2] * s[4],
          s[0] * s[2] + s[1] * s[4] + s[2] * s[5], s[1] * s[1] + s[3] * s[3] + s[4] * s[4],
          s[1] * s[2] + s[3] * s[4] + s[4] * s[5], s[2] * s[2] + s[4] * s[4] + s[5] * s[5]};
}

Vector times(const Symmetric& s, const Vector& x) {
  return {s[0] * x[0] + s[1] * x[1] + s[2] * x[2], s[1] * x[0] + s[3] * x[1] + s[4] * x[2],
          s[2] * x[0] + s[4] * x[1] + s[5] * x[2]};
}

float dot(const Vector& x, const Vector& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }

// The direction of the largest eigenvalue, of length 1; 0 where there is none. Each squaring doubles the power that
// brings it out.
Vector principal_axis(Symmetric s, int squarings) {
  for (int k = 0; k <= squarings; ++k) {
    const float size = trace(s);
    if (!(size > 0)) return {};
    for (float& entry : s) entry /= size;
    if (k < squarings) s = squared(s);
  }
  Vector axis = {s[0], s[1], s[2]};
  if (s[3] > s[0]) axis = {s[1], s[3], s[4]};
  if (s[5] > std::max(s[0], s[3])) axis = {s[2], s[4], s[5]};
  const float length = std::sqrt(dot(axis, axis));
  if (!(length > 0)) return {};
  for (float& x : axis) x /= length;
  return axis;
}

// What lines through texels with this scatter are off: beside the line, and along it by steps of 1/7.
float line_error(const Symmetric& scatter) {
  constexpr float kAlong = 1.0F / 49;
  const Vector axis = principal_axis(scatter, 3);
  const float along = dot(axis, times(scatter, axis));
  return std::max(trace(scatter) - along, 0.0F) + kAlong * along;
}

// A principal axis, and where texels are along it.
struct Axis {
  Vector direction{};
  Bc6hRow along{};
  float low = 0;
  float high = 0;
};

Axis find_axis(const Bc6hRegion& region, const Space& space) {
  Moments sum{};
  for (std::size_t at = 0; at < region.size; ++at) add(sum, moments_of(place(region, space, at), space.weight[at]));
  Axis axis{.direction = principal_axis(scatter_of(sum), 5)};
  for (std::size_t at = 0; at < region.size; ++at) {
    axis.along[at] = dot(axis.direction, place(region, space, at));
    if (!(region.weight[at] > 0)) continue;
    axis.low = std::min(axis.low, axis.along[at]);
    axis.high = std::max(axis.high, axis.along[at]);
  }
  return axis;
}

Bc6hLine line_between(const Space& space, const Axis& axis, float first, float second) {
  Bc6hLine line;
  for (std::size_t c = 0; c < 3; ++c) {
    line.first[c] = space.centre[c] + first * axis.direction[c] / space.scale[c];
    line.second[c] = space.centre[c] + second * axis.direction[c] / space.scale[c];
  }
  return line;
}

// Places along an axis of index 0 and of the last one, and what texels are off along it.
struct Span {
  float first = 0;
  float second = 0;
  float error = 0;
};

// The outermost texels get the indices `low` and `high`, the others what follows, and the ends are where these indices
// want them.
Span fit_span(const Bc6hRegion& region, const Bc6hRow& weight_of, const Axis& axis, const Bc6hScale& scale, int low,
              int high) {
  const std::uint8_t* const weights = scale.weights();
  const auto last = static_cast<float>(scale.index_count - 1);
  const float pace = static_cast<float>(high - low) / (axis.high - axis.low);
  float aa = 0;
  float ab = 0;
  float bb = 0;
  float ax = 0;
  float bx = 0;
  float xx = 0;
  for (std::size_t at = 0; at < region.size; ++at) {
    const float place = std::clamp(static_cast<float>(low) + (axis.along[at] - axis.low) * pace, 0.0F, last);
    const float b = static_cast<float>(weights[static_cast<int>(place + 0.5F)]) / 64;
    const float a = 1 - b;
    const float x = axis.along[at];
    const float weight = weight_of[at];
    aa += weight * a * a;
    ab += weight * a * b;
    bb += weight * b * b;
    ax += weight * a * x;
    bx += weight * b * x;
    xx += weight * x * x;
  }
  const float determinant = aa * bb - ab * ab;
  Span span;
  span.first = (bb * ax - ab * bx) / determinant;
  span.second = (aa * bx - ab * ax) / determinant;
  span.error = xx - span.first * ax - span.second * bx;
  return span;
}

// The nearest index of each texel, as if indices were evenly spaced.
std::array<std::int32_t, 16> indices_along(const Bc6hRegion& region, const Space& space, const Bc6hLine& line,
                                           int index_count) {
  Vector axis{};
  float length = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const float difference = line.second[c] - line.first[c];
    axis[c] = difference * space.scale[c] * space.scale[c];
    length += difference * axis[c];
  }
  std::array<std::int32_t, 16> indices{};
  if (!(length > 0)) return indices;
  const auto last = static_cast<float>(index_count - 1);
  for (std::size_t at = 0; at < region.size; ++at) {
    float along = 0;
    for (std::size_t c = 0; c < 3; ++c) along += (region.mixed[c][at] - line.first[c]) * axis[c];
    indices[at] = static_cast<std::int32_t>(std::clamp(along / length, 0.0F, 1.0F) * last + 0.5F);
  }
  return indices;
}

// How far along a line the anchor is, from 0 to 1; the middle where that cannot be told.
float place_of_anchor(const Bc6hRegion& region, const Bc6hLine& line) {
  float ahead = 0;
  float length = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const float difference = line.second[c] - line.first[c];
    ahead += region.fit_weight[c][0] * (region.mixed[c][0] - line.first[c]) * difference;
    length += region.fit_weight[c][0] * difference * difference;
  }
  return length > 0 ? std::clamp(ahead / length, 0.0F, 1.0F) : 0.5F;
}

}  // namespace

Bc6hLine fit_bc6h_line(const Bc6hRegion& region, int index_count) {
  constexpr int kRounds = 2;
  const Space space = make_space(region);
  if (!(space.scale[0] > 0)) return {};
  const Bc6hScale scale{.index_count = index_count};
  const Axis axis = find_axis(region, space);
  Bc6hLine line = line_between(space, axis, axis.low, axis.high);
  for (int round = 0; round < kRounds; ++round) {
    line = fit_bc6h_line(region, region.fit_weight, indices_along(region, space, line, index_count), scale);
  }
  orient_bc6h_line(region, line);
  return line;
}

void fit_bc6h_lines(const Bc6hRegion& region, int index_count, std::span<Bc6hLine> lines) {
  const Space space = make_space(region);
  std::fill(lines.begin(), lines.end(), fit_bc6h_line(region, index_count));
  if (!(space.scale[0] > 0)) return;
  const Axis axis = find_axis(region, space);
  if (!(axis.high > axis.low)) return;
  const Bc6hScale scale{.index_count = index_count};
  std::array<Span, 120> spans;
  std::size_t count = 0;
  for (int low = 0; low + 1 < index_count; ++low) {
    for (int high = low + 1; high < index_count; ++high)
      spans[count++] = fit_span(region, space.weight, axis, scale, low, high);
  }
  const std::size_t wanted = std::min(count, lines.size());
  std::partial_sort(spans.begin(), spans.begin() + static_cast<std::ptrdiff_t>(wanted),
                    spans.begin() + static_cast<std::ptrdiff_t>(count),
                    [](const Span& a, const Span& b) { return a.error < b.error; });
  for (std::size_t k = 0; k < wanted; ++k) {
    lines[k] = line_between(space, axis, spans[k].first, spans[k].second);
    orient_bc6h_line(region, lines[k]);
  }
}

Bc6hLine fit_bc6h_line(const Bc6hRegion& region, const Bc6hRows& fit_weight, std::span<const std::int32_t, 16> indices,
                       const Bc6hScale& scale) {
  const std::uint8_t* const weights = scale.weights();
  Bc6hLine line;
  for (std::size_t c = 0; c < 3; ++c) {
    const float origin = region.mixed[c][0];  // near the others, so that sums keep their digits
    float aa = 0;
    float ab = 0;
    float bb = 0;
    float ax = 0;
    float bx = 0;
    for (std::size_t at = 0; at < region.size; ++at) {
      const float b = static_cast<float>(weights[indices[at]]) / 64;
      const float a = 1 - b;
      const float weight = fit_weight[c][at];
      const float x = weight * (region.mixed[c][at] - origin);
      aa += weight * a * a;
      ab += weight * a * b;
      bb += weight * b * b;
      ax += a * x;
      bx += b * x;
    }
    const float determinant = aa * bb - ab * ab;
    const float total = aa + 2 * ab + bb;
    if (determinant > 1e-4F * total * total) {
      line.first[c] = origin + (bb * ax - ab * bx) / determinant;
      line.second[c] = origin + (aa * bx - ab * ax) / determinant;
    } else {
      line.first[c] = line.second[c] = origin + (total > 0 ? (ax + bx) / total : 0.0F);
    }
  }
  return line;
}

void orient_bc6h_line(const Bc6hRegion& region, Bc6hLine& line) {
  if (place_of_anchor(region, line) > 0.5F) std::swap(line.first, line.second);
}

std::array<Bc6hLine, kBc6hStretches> stretched_bc6h_lines(const Bc6hRegion& region, const Bc6hLine& line,
                                                          int index_count) {
  // As far as an anchor may be.
  const float farthest = static_cast<float>(index_count == 8 ? kBc6hWeights3[3] : kBc6hWeights4[7]) / 64;
  const float place = place_of_anchor(region, line);
  const float most = std::max((farthest - place) / (1 - farthest), 0.0F);
  const float least = std::max((1 - place) / farthest, 1.0F) - 1;
  const auto beyond = [](const std::array<float, 3>& from, const std::array<float, 3>& to, float share) {
    std::array<float, 3> place_beyond{};
    for (std::size_t c = 0; c < 3; ++c) place_beyond[c] = to[c] + share * (to[c] - from[c]);
    return place_beyond;
  };
  const std::array<float, 3> far_end = beyond(line.second, line.first, least);
  return {{{beyond(line.second, line.first, 0.5F * most), line.second},
           {beyond(line.second, line.first, most), line.second},
           {line.second, far_end},
           {beyond(line.first, line.second, 0.5F), beyond(line.second, line.first, least + 0.5F)}}};
}

std::array<float, kBc6hPartitionCount> rate_bc6h_partitions(const Bc6hRegion& whole) {
  const Space space = make_space(whole);
  std::array<Moments, 16> moments{};
  Moments all{};
  for (std::size_t at = 0; at < 16; ++at) {
    moments[at] = moments_of(place(whole, space, at), space.weight[at]);
    add(all, moments[at]);
  }
  std::array<float, kBc6hPartitionCount> errors{};
  for (std::size_t partition = 0; partition < errors.size(); ++partition) {
    Moments second{};
    for (std::size_t at = 1; at < 16; ++at) {
      if ((kBc6hPartitions[partition] >> at & 1U) != 0) add(second, moments[at]);
    }
    Moments first = all;
    for (std::size_t k = 0; k < first.size(); ++k) first[k] -= second[k];
    errors[partition] = line_error(scatter_of(first)) + line_error(scatter_of(second));
  }
  return errors;
}

}  // namespace sbrdf::internal
