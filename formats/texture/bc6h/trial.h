#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "formats/texture/bc6h/line_fit.h"
#include "formats/texture/bc6h/region.h"

// A way to encode a block, what it is off, and how it gets better.

namespace sbrdf::internal {

/// Mode, partition and rounded endpoints. Indices follow from them.
struct Bc6hTrial {
  std::uint8_t mode = 0;
  std::uint8_t partition = 0;
  std::array<Bc6hEndpoint, 4> endpoints{};
  std::array<float, 2> errors{};  ///< of the regions
  /// Differences from the first endpoint were too large for the mode, but need not be for another first endpoint.
  bool wants_other_start = false;

  [[nodiscard]] float error() const { return errors[0] + errors[1]; }
};

/// The lines of both regions as near as a mode can store them. Where differences from the first endpoint are too large
/// for it, they are cut. `regions` and `lines`: one or two, as the mode has.
[[nodiscard]] Bc6hTrial make_bc6h_trial(std::span<const Bc6hRegion> regions, std::span<const Bc6hLine> lines,
                                        std::uint8_t mode, std::uint8_t partition, const Bc6hOptions& options);

/// Least squares with the indices of the trial, again and again as long as it gets better, `rounds` times at most.
void refit_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options, int rounds, Bc6hTrial& trial);

/// Puts other lines in the place of those of a region, rounded, and the `polished` best of them moved by steps; keeps
/// what is better. `lines`: of region `k`.
void try_bc6h_lines(std::span<const Bc6hRegion> regions, std::span<const Bc6hLine> lines, std::size_t k,
                    const Bc6hOptions& options, std::size_t polished, Bc6hTrial& trial);

/// Moves both endpoints of a region by steps, in one channel after the other or in all of them, as long as it gets
/// better.
void polish_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options, Bc6hTrial& trial);

/// The block itself.
[[nodiscard]] Bc6hBytes emit_bc6h_trial(std::span<const Bc6hRegion> regions, const Bc6hOptions& options,
                                        const Bc6hTrial& trial);

}  // namespace sbrdf::internal
