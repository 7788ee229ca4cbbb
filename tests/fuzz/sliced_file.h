#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/file/index.h"
#include "formats/sbrdf/container.h"
#include "tests/fuzz/require.h"

namespace sbrdf::internal::fuzzing {

/// A sliced file in parts that can be changed one by one. Whether they fit each other is for a reader to say.
struct SlicedParts {
  std::uint8_t minor = kContainerMinor;
  SlicedIndex index;
  std::vector<Bytes> payloads;  ///< of all chunks, empty ones included
};

/// Nothing where the index cannot be parsed or the chunks do not lie within the file. Checksums are not looked at.
[[nodiscard]] std::optional<SlicedParts> take_apart(const Bytes& file);
/// Sizes in the index and checksums are made to fit the payloads.
[[nodiscard]] Bytes put_together(const SlicedParts& parts);

/// Mutates a sliced file and then, mostly, mends its checksums and sizes, so that the mutation reaches what is behind
/// them: anywhere, within the index, within one chunk, or one field of the index. For LLVMFuzzerCustomMutator.
std::size_t mutate_sliced(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed);

/// Reads a file in every way there is: whole, down to a depth, around one pair of directions. Requires that all ways
/// agree and, where it decodes, that it is the same after it was written again.
void exercise_sliced(const Bytes& file);

}  // namespace sbrdf::internal::fuzzing
