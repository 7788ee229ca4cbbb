#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/core/byte_source.h"

namespace sbrdf::internal {

/// A text in memory, with files beside it.
class InFolder final : public ByteSource {
 public:
  explicit InFolder(const std::string& text) : text_(text) {}

  std::map<std::string, std::vector<std::byte>> files;

  [[nodiscard]] std::uint64_t size() const override { return text_.size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    return MemorySource(std::as_bytes(std::span(text_))).read(offset, target);
  }
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> neighbour(const std::string& name) const override {
    std::shared_ptr<const ByteSource> found;
    if (files.contains(name)) found = std::make_shared<OwnedMemorySource>(files.at(name));
    return found;
  }

 private:
  std::string text_;
};

}  // namespace sbrdf::internal
