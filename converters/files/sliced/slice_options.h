#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "converters/files/options.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {

// The texts that options of sliced files hold, and the SliceOptions that they mean. A name such as "half-difference" is
// written down once, in converters/slicing/names.h.

/// A placement e_s/a_s such as "14/36": two positive numbers of degrees; nothing for other texts.
[[nodiscard]] std::optional<Placement> parse_steps(std::string_view text);

/// The options of sliced files: where slices lie, how they are sampled and when to stop, and how they are coded. Each
/// has a line in specs/sbrdf.md.
[[nodiscard]] std::span<const OptionSpec> sliced_options();

/// kUsage, naming both, for options of which one would have no effect: that is a misunderstanding.
[[nodiscard]] Status check_slice_options(const Options& options);

/// What an .sbrdf file holds: slices, the dense table of section 14, or the one of both that serves its target better.
enum class Representation : std::uint8_t { kSliced, kDense, kAuto };
[[nodiscard]] Representation representation_of(const Options& options);

/// Some option asks for sampling; those of coding (precision, chunks) do not.
[[nodiscard]] bool ask_for_sampling(const Options& options);

/// What the texts mean, defaults where there are none. They have passed check_options and check_slice_options.
[[nodiscard]] SliceOptions slice_options(const Options& options);

}  // namespace sbrdf::internal
