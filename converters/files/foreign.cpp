#include "converters/files/foreign.h"

#include <algorithm>
#include <array>
#include <string>

namespace sbrdf::internal {
namespace {

using namespace std::string_view_literals;

struct Foreign {
  std::string_view start;
  std::string_view name;
};

constexpr std::array kByMagic = {
    Foreign{"version https://git-lfs.github.com/"sv, "a Git LFS pointer, not the file that it stands for"},
    Foreign{"version https://hawser.github.com/"sv, "a Git LFS pointer, not the file that it stands for"},
    Foreign{"{\"sbrdf\":\"dense table\""sv, "the description of a dense table; open the .npy file that it belongs to"},
    Foreign{"\x1F\x8B"sv, "gzip-compressed data; unpack it first"},
    Foreign{"PK\x03\x04"sv, "a zip archive; unpack it first"},
    Foreign{"PK\x05\x06"sv, "a zip archive without files"},
    Foreign{"\x28\xB5\x2F\xFD"sv, "zstd-compressed data; unpack it first"},
    Foreign{"\xFD\x37zXZ\0"sv, "XZ-compressed data; unpack it first"},
    Foreign{"<?xml"sv, "an XML file without the root element WindowElement, that of Klems matrices"},
    Foreign{"\xEF\xBB\xBF<?xml"sv, "an XML file without the root element WindowElement, that of Klems matrices"},
    Foreign{"\0\x05\x16\x07"sv, "an AppleDouble file, which holds attributes of a file but not its content"},
};

constexpr std::array kMarkup = {"<!doctype html"sv, "<html"sv, "<head"sv, "<body"sv};

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return result;
}

// Pages may begin with a byte order mark, white space and comments.
bool is_web_page(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const std::size_t end = text.starts_with("<!--") ? text.find("-->") : std::string_view::npos;
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 3);
  }
  const std::string start = lower(text.substr(0, 32));
  return std::any_of(kMarkup.begin(), kMarkup.end(), [&](std::string_view tag) { return start.starts_with(tag); });
}

}  // namespace

std::optional<std::string_view> name_foreign(std::span<const std::byte> head) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  for (const Foreign& foreign : kByMagic) {
    if (text.starts_with(foreign.start)) return foreign.name;
  }
  if (is_web_page(text)) return "a web page (HTML), not the file that was meant";
  return std::nullopt;
}

bool is_text(std::span<const std::byte> head) {
  return std::all_of(head.begin(), head.end(), [](std::byte b) {
    const int c = std::to_integer<int>(b);
    return (c >= 32 && c != 127) || c == '\n' || c == '\r' || c == '\t';
  });
}

}  // namespace sbrdf::internal
