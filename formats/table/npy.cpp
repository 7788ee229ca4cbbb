#include "formats/table/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "formats/core/byte_reader.h"
#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kMagic = "\x93NUMPY"sv;
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kMostAxes = 32;
constexpr std::size_t kNumberOffset = 10;  // of the text in version 1.0

/// Reads the dictionary, which is a literal of Python: {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }.
/// Nothing is evaluated.
class DictionaryReader {
 public:
  DictionaryReader(std::string_view text, std::uint64_t offset) : text_(text), offset_(offset) {}

  Result<NpyHeader> read() {
    if (!take('{')) return wrong("does not begin with '{'");
    while (!take('}')) {
      if (Status read = read_entry(); !read) return read.error();
      if (take(',')) continue;
      if (!take('}')) return wrong("',' or '}' expected");
      break;
    }
    skip_blanks();
    if (at_ != text_.size()) return wrong("something follows the dictionary");
    if (!has_descr_ || !has_order_ || !has_shape_) return wrong("'descr', 'fortran_order' or 'shape' is missing");
    return header_;
  }

 private:
  Status read_entry() {
    const std::optional<std::string_view> key = take_text();
    if (!key || !take(':')) return wrong("a name and ':' expected");
    if (*key == "descr") return read_descr();
    if (*key == "fortran_order") return read_order();
    if (*key == "shape") return read_shape();
    return wrong("an entry that no array has");
  }

  Status read_descr() {
    if (has_descr_) return wrong("'descr' stands twice");
    has_descr_ = true;
    skip_blanks();
    if (at_ < text_.size() && text_[at_] == '[') {
      return unsupported("an NPY file of records; arrays of float16, float32 and float64 are read", offset_ + at_);
    }
    const std::optional<std::string_view> type = take_text();
    if (!type) return wrong("'descr' is no text");
    if (type->ends_with('O')) {
      return unsupported("an NPY file of Python objects (pickled), which are not unpacked", offset_ + at_);
    }
    if (*type == ">f2" || *type == ">f4" || *type == ">f8") {
      return unsupported(
          fmt::format("an NPY file of big-endian numbers ('{}'); only little-endian ones are read", *type),
          offset_ + at_);
    }
    if (*type != "<f2" && *type != "<f4" && *type != "<f8") {
      return unsupported(fmt::format("an NPY file of numbers of the type '{}'; float16, float32 and float64 are read",
                                     printable(*type)),
                         offset_ + at_);
    }
    header_.number_size = static_cast<std::size_t>(type->back() - '0');
    return ok_status();
  }

  Status read_order() {
    if (has_order_) return wrong("'fortran_order' stands twice");
    has_order_ = true;
    if (take_word("True")) {
      header_.fortran_order = true;
    } else if (!take_word("False")) {
      return wrong("'fortran_order' is neither True nor False");
    }
    return ok_status();
  }

  Status read_shape() {
    if (has_shape_) return wrong("'shape' stands twice");
    has_shape_ = true;
    if (!take('(')) return wrong("'shape' is no tuple");
    while (!take(')')) {
      const std::optional<std::uint64_t> size = take_count();
      if (!size) return wrong("'shape' holds what is no count");
      if (header_.shape.size() == kMostAxes) return wrong("more than 32 axes");
      header_.shape.push_back(*size);
      take('L');  // as Python 2 wrote them
      if (take(',')) continue;
      if (!take(')')) return wrong("',' or ')' expected");
      break;
    }
    return ok_status();
  }

  [[nodiscard]] Error wrong(std::string_view what) const {
    return invalid_file(fmt::format("NPY header: {}", what), offset_ + at_);
  }

  [[nodiscard]] static std::string printable(std::string_view text) {
    std::string result(text.substr(0, 40));
    std::replace_if(
        result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return result;
  }

  void skip_blanks() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }

  bool take(char wanted) {
    skip_blanks();
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }

  bool take_word(std::string_view word) {
    skip_blanks();
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }

  std::optional<std::string_view> take_text() {
    skip_blanks();
    if (at_ == text_.size() || (text_[at_] != '\'' && text_[at_] != '"')) return std::nullopt;
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view text = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return text;
  }

  std::optional<std::uint64_t> take_count() {
    skip_blanks();
    const std::size_t end = std::min(text_.find_first_not_of("0123456789", at_), text_.size());
    const std::optional<std::uint64_t> count = parse_count(text_.substr(at_, end - at_));
    if (count) at_ = end;
    return count;
  }

  std::string_view text_;
  std::uint64_t offset_;
  std::size_t at_ = 0;
  NpyHeader header_;
  bool has_descr_ = false;
  bool has_order_ = false;
  bool has_shape_ = false;
};

std::string shape_text(std::span<const std::uint64_t> shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

// Each product is checked: three hostile sizes can wrap to the right number.
std::optional<std::uint64_t> size_of_numbers(const NpyHeader& header) {
  std::uint64_t size = header.number_size;
  for (const std::uint64_t count : header.shape) {
    if (count != 0 && size > std::numeric_limits<std::uint64_t>::max() / count) return std::nullopt;
    size *= count;
  }
  return size;
}

Status check_size(const NpyHeader& header, std::uint64_t file_size) {
  const std::uint64_t present = file_size - header.data_offset;
  const std::optional<std::uint64_t> wanted = size_of_numbers(header);
  if (wanted && *wanted == present) return ok_status();
  const bool cut = !wanted || *wanted > present;
  return invalid_file(
      fmt::format(
          "{}: an array of shape {} and {} bytes for each number needs {} bytes behind the header, the file has {}",
          cut ? "truncated NPY file" : "bytes after the end of the NPY array", shape_text(header.shape),
          header.number_size, wanted ? std::to_string(*wanted) : "more than 2^64", present),
      cut ? file_size : header.data_offset + *wanted);
}

}  // namespace

std::uint64_t NpyHeader::number_count() const {
  std::uint64_t count = 1;
  for (const std::uint64_t size : shape) count *= size;
  return count;
}

bool recognises_npy(std::span<const std::byte> head) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  return text.starts_with(kMagic);
}

Result<NpyHeader> parse_npy_header(std::span<const std::byte> start, std::uint64_t file_size) {
  ByteReader in(start);
  if (in.text(kMagic.size()) != kMagic) return invalid_file("no NPY file: it does not begin with \\x93NUMPY", 0);
  const std::uint8_t major = in.u8();
  const std::uint8_t minor = in.u8();
  if (in.ok() && (major < 1 || major > 3 || minor != 0)) {
    return unsupported(fmt::format("NPY version {}.{}; 1.0, 2.0 and 3.0 are read", major, minor), kMagic.size());
  }
  const std::uint64_t length = major == 1 ? in.u16() : in.u32();
  if (in.ok() && length > kNpyLongestHeader - in.offset()) {
    return unsupported(fmt::format("an NPY header of {} bytes; arrays of floats need some 100", length), in.offset());
  }
  const std::uint64_t offset = in.offset();
  const std::string text = in.text(length);
  if (!in.ok()) return in.error();
  Result<NpyHeader> header = DictionaryReader(text, offset).read();
  if (!header) return header;
  header->data_offset = offset + length;
  if (Status fits = check_size(*header, file_size); !fits) return fits.error();
  return header;
}

std::vector<std::byte> emit_npy_header(std::size_t number_size, std::span<const std::uint64_t> shape) {
  assert(number_size == 2 || number_size == 4 || number_size == 8);
  std::string text =
      fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': {}, }}", number_size, shape_text(shape));
  const std::size_t size = kNumberOffset + text.size() + 1;
  text.append((kAlignment - size % kAlignment) % kAlignment, ' ');
  text += '\n';
  ByteWriter out;
  out.text(kMagic);
  out.number(std::uint8_t{1});
  out.number(std::uint8_t{0});
  out.number(static_cast<std::uint16_t>(text.size()));
  out.text(text);
  return std::move(out).take();
}

}  // namespace sbrdf::internal
