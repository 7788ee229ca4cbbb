#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// OpenEXR images of one part, in scan lines, of half or float channels, read and written by the OpenEXR library. Its
// exceptions end here.

/// The file begins as an OpenEXR file does.
[[nodiscard]] bool recognises_exr(std::span<const std::byte> head);

struct ExrChannel {
  std::string name;
  bool half = false;  ///< 16-bit floats; else 32-bit ones
};

/// What the header of an image says.
struct ExrHeader {
  std::uint32_t width = 0;  ///< of the data window
  std::uint32_t height = 0;
  std::vector<ExrChannel> channels;  ///< in the order of the file: sorted by name
  std::string text;                  ///< of the string attribute that was asked for; empty where there is none
  std::uint64_t block_size = 0;      ///< of the rows that are unpacked together [bytes]; reading takes four times that
};

/// An image that can be read. Keeps its bytes.
class ExrReader {
 public:
  /// Looks at the header only. Every size in it is checked against the bytes of the file before the library sees it.
  ///
  /// `attribute`: name of the string attribute whose text is wanted. kInvalidFile where this is no OpenEXR file, where
  /// its header is cut off or contradicts itself; kUnsupported for images in tiles, of several parts, deep ones,
  /// channels that are no floats or have fewer pixels than the image, and compression that changes values much (B44,
  /// DWA); the errors of reading `bytes`.
  [[nodiscard]] static Result<std::unique_ptr<ExrReader>> open(std::shared_ptr<const ByteSource> bytes,
                                                               std::string_view attribute);
  ExrReader(const ExrReader&) = delete;
  ExrReader& operator=(const ExrReader&) = delete;
  virtual ~ExrReader() = default;

  [[nodiscard]] virtual const ExrHeader& header() const = 0;
  /// All pixels of the channels with these names, which are in the header: rows from above, channel fastest, little-
  /// endian halves or floats as `half` says. `target` has the size of that. kInvalidFile where rows are missing or
  /// damaged.
  [[nodiscard]] virtual Status read(std::span<const std::string> channels, bool half, std::span<std::byte> target) = 0;

 protected:
  ExrReader() = default;
};

/// An image that is written row by row, ZIP-compressed.
class ExrWriter {
 public:
  struct Image {
    std::uint64_t width = 0;
    std::uint64_t height = 0;
    std::vector<std::string> channels;  ///< in the order of the values that are given
    bool half = false;
    std::string attribute;  ///< name of a string attribute
    std::string text;       ///< its value
  };
  /// Longest name of a channel [bytes].
  static constexpr std::size_t kLongestName = 255;

  /// Whether there can be such an image. kUnsupported where a side is longer than 2^31 - 1, where 16 rows take more
  /// than 2^31 - 1 bytes, and where a channel has a name that is empty, too long or used twice.
  [[nodiscard]] static Status check(const Image& image);
  /// Writes the header. `image` must have passed check(). `sink` must outlive what is returned.
  [[nodiscard]] static Result<std::unique_ptr<ExrWriter>> create(ByteSink& sink, const Image& image);
  ExrWriter(const ExrWriter&) = delete;
  ExrWriter& operator=(const ExrWriter&) = delete;
  virtual ~ExrWriter() = default;

  /// The next row: width x channels numbers as `half` says, little-endian, channel fastest.
  [[nodiscard]] virtual Status write_row(std::span<const std::byte> numbers) = 0;
  /// After the last row. `text` takes the place of the attribute's value and has its length.
  [[nodiscard]] virtual Status finish(std::string_view text) = 0;

 protected:
  ExrWriter() = default;
};

}  // namespace sbrdf::internal
