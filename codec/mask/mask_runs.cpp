#include "codec/mask/mask_runs.h"

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {

std::vector<std::byte> emit_runs(const DirectionMask& mask) {
  ByteWriter out;
  std::uint64_t length = 0;
  bool unmeasured = false;
  for (const bool bit : mask.unmeasured) {
    if (bit != unmeasured) {
      out.count(length);
      length = 0;
      unmeasured = bit;
    }
    ++length;
  }
  out.count(length);
  return std::move(out).take();
}

std::optional<DirectionMask> parse_runs(std::span<const std::byte> bytes, const MaskGrid& grid) {
  ByteReader in(bytes);
  DirectionMask mask = {grid, {}};
  const std::uint64_t cells = grid.cell_count();
  mask.unmeasured.reserve(cells);
  for (bool unmeasured = false; in.remaining() > 0; unmeasured = !unmeasured) {
    const bool first = mask.unmeasured.empty() && !unmeasured;
    const std::uint32_t length = static_cast<std::uint32_t>(in.count(32));
    if (!in.ok() || (length == 0 && !first) || length > cells - mask.unmeasured.size()) return std::nullopt;
    mask.unmeasured.insert(mask.unmeasured.end(), length, unmeasured);
  }
  if (mask.unmeasured.size() != cells) return std::nullopt;
  return mask;
}

}  // namespace sbrdf::internal
