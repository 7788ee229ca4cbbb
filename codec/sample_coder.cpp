#include "codec/sample_coder.h"

#include <cstring>

namespace sbrdf::coding {

void merge_found(SliceLevels& slice, std::size_t channels, int level) {
  const std::size_t known = slice.size();
  const std::size_t count = slice.found.size();
  slice.places.resize(known + count);
  slice.positions_deg.resize(known + count);
  slice.depths.resize(known + count);
  const auto behind = static_cast<std::ptrdiff_t>(known * channels);
  slice.fresh.levels.assign(slice.table.levels.begin() + behind, slice.table.levels.end());
  slice.fresh.residuals.assign(slice.table.residuals.begin() + behind, slice.table.residuals.end());
  // A run of known samples goes up by as many places as were found before it.
  const auto move_run = [&](auto& values, std::size_t from, std::size_t end, std::size_t up, std::size_t width) {
    auto* first = values.data() + from * width;
    std::memmove(first + up * width, first, (end - from) * width * sizeof(*first));
  };
  std::size_t old = known;
  for (std::size_t f = count; f-- > 0;) {
    const std::size_t from = slice.found[f].left + 1;
    move_run(slice.places, from, old, f + 1, 1);
    move_run(slice.positions_deg, from, old, f + 1, 1);
    move_run(slice.depths, from, old, f + 1, 1);
    move_run(slice.table.levels, from, old, f + 1, channels);
    move_run(slice.table.residuals, from, old, f + 1, channels);
    old = from;
    const std::size_t target = from + f;
    slice.places[target] = slice.found[f].place;
    slice.positions_deg[target] = slice.found[f].position_deg;
    slice.depths[target] = static_cast<std::uint8_t>(level);
    for (std::size_t c = 0; c < channels; ++c) {
      slice.table.levels[target * channels + c] = slice.fresh.levels[f * channels + c];
      slice.table.residuals[target * channels + c] = slice.fresh.residuals[f * channels + c];
    }
  }
  slice.deepest = level;
}

Stencil stencil_around(const SliceLevels& slice, std::size_t known, std::size_t gap, double at) {
  Stencil stencil;
  std::array<double, 4> positions{};
  const auto n = static_cast<std::int64_t>(known);
  for (std::int64_t index = static_cast<std::int64_t>(gap) - 1; index <= static_cast<std::int64_t>(gap) + 2; ++index) {
    std::int64_t member = index;
    double& position = positions[stencil.count];
    if (index >= 0 && index < n) {
      position = slice.positions_deg[static_cast<std::size_t>(member)];
    } else if (slice.boundary == Boundary::kPeriodic) {
      member = (index % n + n) % n;
      position = slice.positions_deg[static_cast<std::size_t>(member)] +
                 static_cast<double>((index - member) / n) * slice.length_deg;
    } else {
      member = index < 0 ? -index : 2 * (n - 1) - index;
      if (slice.boundary == Boundary::kBounded || member < 0 || member >= n) continue;
      const double end = index < 0 ? slice.positions_deg.front() : slice.positions_deg[known - 1];
      position = 2 * end - slice.positions_deg[static_cast<std::size_t>(member)];
    }
    stencil.member[stencil.count++] = static_cast<std::uint32_t>(member);
  }
  set_weights(stencil, std::span(positions).first(stencil.count), at);
  return stencil;
}

}  // namespace sbrdf::coding
