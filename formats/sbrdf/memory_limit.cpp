#include "formats/sbrdf/memory_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sbrdf::internal {
namespace {

constexpr double kMebibyte = 1 << 20;

std::string mebibytes(double bytes) { return std::to_string(static_cast<std::uint64_t>(std::ceil(bytes / kMebibyte))); }

}  // namespace

std::uint64_t MemoryLimit::of(std::uint64_t stored_size) const {
  if (bytes) return *bytes;
  constexpr std::uint64_t kMost = (std::numeric_limits<std::uint64_t>::max() - kAlways) / kPerByte;
  return kAlways + kPerByte * std::min(stored_size, kMost);
}

Status check_memory(double needed, std::uint64_t allowed) {
  if (needed <= static_cast<double>(allowed)) return ok_status();
  return unsupported("reading it takes up to " + mebibytes(needed) + " MiB of memory, the limit is " +
                     mebibytes(static_cast<double>(allowed)) + " MiB (sbrdf.md, section 12); --memory-limit " +
                     mebibytes(needed) + " allows it");
}

}  // namespace sbrdf::internal
