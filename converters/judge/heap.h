#pragma once

#include <cstdint>

namespace sbrdf::internal {

/// Bytes on the heap now, all threads together; 0 where the C library does not tell.
[[nodiscard]] std::uint64_t heap_bytes();

}  // namespace sbrdf::internal
