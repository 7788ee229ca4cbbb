// Writes what the decoder makes of BC6H blocks, for comparison with other decoders.
//
// usage: dump_bc6h unsigned|signed BLOCKS HALVES_OUT
//   BLOCKS      16 bytes each
//   HALVES_OUT  u16, the bits of halves: for each block its 16 texels row by row, R, G, B
// Exit codes: 0 ok, 1 usage, 2 a file cannot be read or written.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/texture/bc6h/bc6h.h"

namespace sbrdf::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

int dump(bool is_signed, const char* blocks_path, const char* halves_path) {
  std::ifstream blocks(blocks_path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(blocks), std::istreambuf_iterator<char>()};
  const std::vector<std::uint8_t> bytes(content.begin(), content.end());
  if (!blocks || bytes.size() % kBc6hBlockSize != 0) {
    std::cerr << blocks_path << " cannot be read, or ends within a block\n";
    return 2;
  }
  std::ofstream halves(halves_path, std::ios::binary);
  for (std::size_t at = 0; at < bytes.size(); at += kBc6hBlockSize) {
    const Bc6hTexels texels = decode_bc6h_block(std::span(bytes).subspan(at).first<kBc6hBlockSize>(), is_signed);
    halves.write(reinterpret_cast<const char*>(texels.data()), sizeof texels);
  }
  if (!halves.flush()) {
    std::cerr << halves_path << " cannot be written\n";
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace sbrdf::internal

int main(int count, char** arguments) {
  const std::string_view kind = count == 4 ? arguments[1] : "";
  if (kind != "unsigned" && kind != "signed") {
    std::cerr << "usage: dump_bc6h unsigned|signed BLOCKS HALVES_OUT\n";
    return 1;
  }
  try {
    return sbrdf::internal::dump(kind == "signed", arguments[2], arguments[3]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
