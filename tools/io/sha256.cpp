#include "tools/io/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "formats/os/files.h"
#include "formats/os/interrupt.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20U;

}  // namespace

std::string sha256_of(const std::filesystem::path& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  return file ? sha256_of(**file) : std::string();
}

std::string sha256_of(const ByteSource& bytes) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (!context || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1) return {};
  std::vector<std::byte> piece;
  for (std::uint64_t offset = 0; offset < bytes.size(); offset += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, bytes.size() - offset)));
    if (interrupted()) return {};
    if (!bytes.read(offset, piece) || EVP_DigestUpdate(context.get(), piece.data(), piece.size()) != 1) return {};
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_DigestFinal_ex(context.get(), digest.data(), &size) != 1) return {};
  std::string text;
  for (unsigned k = 0; k < size; ++k) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    text += kDigits[digest[k] >> 4U];
    text += kDigits[digest[k] & 15U];
  }
  return text;
}

}  // namespace sbrdf::internal
