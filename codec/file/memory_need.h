#pragma once

#include "codec/file/index.h"
#include "codec/frame/lattice.h"

namespace sbrdf::internal {

// What reading a file and evaluating it takes [bytes], from above, so that a limit can be held before anything is
// allocated. Each term is what one table holds of a thing, twice where the table grows as it is filled. As doubles:
// no product of hostile numbers wraps. specs/sbrdf.md, section 12.

/// Of an index of so many bytes: itself, the sizes and offsets of chunks that it may list, one a byte.
[[nodiscard]] double memory_of_index(std::size_t index_size);

/// Of the metadata: packed, as text, as text again in which every byte takes an escape.
[[nodiscard]] double memory_of_metadata(const SlicedIndex& index);

/// Of the mask of unmeasured directions: packed, as runs, and a bit for each cell. 0 where there is none.
[[nodiscard]] double memory_of_mask(const SlicedIndex& index);

/// Of the lattice, before there is one: from the number of its points, those of its azimuths, and nothing else.
[[nodiscard]] double memory_of_lattice(const FrameSpec& frame);

/// Of all values, and of an evaluator of them, with the lattice.
[[nodiscard]] double memory_of_samples(const SlicedIndex& index, const Lattice& lattice);

/// Of one sample of a slice that is being decoded.
[[nodiscard]] double memory_of_decoded_sample(std::size_t channels);

}  // namespace sbrdf::internal
