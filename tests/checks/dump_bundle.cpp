// Writes all files of a bundle, for comparison with the reference reader (specs/reference/).
//
// usage: dump_bundle BUNDLE OUT
//   OUT  for each material: u64 size of its name, name, u64 size of its file, file
// Exit codes: 0 ok, 2 a file cannot be read or written, 3 refused, 4 unsupported, with the message on stderr.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/core/byte_reader.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/bundle.h"

namespace sbrdf::internal {
namespace {

Result<std::vector<std::byte>> unpacked(const ByteSource& source) {
  const Result<BundleReader> reader = BundleReader::open(source);
  if (!reader) return reader.error();
  ByteWriter out;
  for (const BundleEntry& entry : reader->entries()) {
    const auto material = reader->material(entry);
    if (!material) return material.error();
    const auto file = read_range(**material, 0, (*material)->size());
    if (!file) return file.error();
    out.number(std::uint64_t{entry.name.size()});
    out.text(entry.name);
    out.number(std::uint64_t{file->size()});
    out.bytes(*file);
  }
  return std::move(out).take();
}

int dump(const char* path, const char* out_path) {
  std::ifstream file(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto bytes = unpacked(MemorySource(std::as_bytes(std::span(content))));
  if (!bytes) {
    std::cerr << bytes.error().message << '\n';
    return static_cast<int>(bytes.error().code);
  }
  std::ofstream out(out_path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  return file && out.flush() ? 0 : static_cast<int>(ErrorCode::kIo);
}

}  // namespace
}  // namespace sbrdf::internal

int main(int count, char** arguments) {
  if (count != 3) {
    std::cerr << "usage: dump_bundle BUNDLE OUT\n";
    return static_cast<int>(sbrdf::internal::ErrorCode::kUsage);
  }
  try {
    return sbrdf::internal::dump(arguments[1], arguments[2]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(sbrdf::internal::ErrorCode::kIo);
  }
}
