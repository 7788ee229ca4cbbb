#include "formats/sbrdf/channel_names.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace sbrdf::internal {
namespace {

constexpr std::array<std::string_view, 3> kUsualNames = {"R", "G", "B"};

}  // namespace

void put_channel_names(ByteWriter& out, const std::vector<std::string>& channels) {
  if (std::equal(channels.begin(), channels.end(), kUsualNames.begin(), kUsualNames.end())) return out.count(0);
  out.count(channels.size());
  for (const std::string& name : channels) {
    out.count(name.size());
    out.text(name);
  }
}

Status take_channel_names(ByteReader& in, std::vector<std::string>& channels) {
  const std::uint64_t count = in.count(32);
  if (count > kMostNamedChannels) return invalid_file("[SB-2-6] " + std::to_string(count) + " channels");
  if (count == 0) channels.assign(kUsualNames.begin(), kUsualNames.end());
  for (std::uint64_t c = 0; c < count && in.ok(); ++c) channels.push_back(in.text(in.count(32)));
  return ok_status();
}

}  // namespace sbrdf::internal
