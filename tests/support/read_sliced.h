#pragma once

#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "codec/file/encoder.h"

namespace sbrdf::internal {

/// A sliced file for a benchmark; says on standard error why it cannot be read.
inline Result<DecodedSliced> read_sliced(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  Result<DecodedSliced> read = decode_sliced(std::as_bytes(std::span(text.data(), text.size())));
  if (!read) std::fprintf(stderr, "%s: %s\n", path, read.error().message.c_str());
  return read;
}

}  // namespace sbrdf::internal
