#include "tools/io/notes.h"

#include <cstdint>
#include <memory>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/os/files.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kLargestNote = std::uint64_t{1} << 26U;  // bytes

}  // namespace

std::string note_text(const Json& note) { return note.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json as_noted(const Json& note) { return Json::parse(note_text(note)); }

Json read_note(const std::string& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file || (*file)->size() > kLargestNote) return {};
  const Result<std::vector<std::byte>> bytes = read_range(**file, 0, (*file)->size());
  if (!bytes) return {};
  const auto* first = reinterpret_cast<const char*>(bytes->data());
  Json note = Json::parse(first, first + bytes->size(), nullptr, false);
  return note.is_object() ? note : Json();
}

}  // namespace sbrdf::internal
