#include "formats/table/exr_image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "formats/table/exr_header.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMostBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t kRowsOfBlock = 16;

std::size_t number_size(bool half) { return half ? 2 : 4; }

Imf::FrameBuffer frame_buffer(std::span<const std::string> channels, bool half, const std::byte* first,
                              const Imath::Box2i& window) {
  const std::size_t pixel = channels.size() * number_size(half);
  const auto width = static_cast<std::size_t>(std::int64_t{window.max.x} - window.min.x + 1);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::byte* place = first + c * number_size(half);
    buffer.insert(channels[c], Imf::Slice::Make(half ? Imf::HALF : Imf::FLOAT, place, window, pixel, width * pixel));
  }
  return buffer;
}

/// What the library throws of itself is about the file.
Error library_error(const std::exception& thrown) {
  std::string text = thrown.what();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
  return invalid_file("OpenEXR: " + text);
}

/// The file with a header in which all attributes but those that an image needs are made unknown to the library, which
/// then skips them.
class SourceStream final : public Imf::IStream {
 public:
  SourceStream(const ByteSource& bytes, std::span<const std::byte> header)
      : Imf::IStream("image"), bytes_(bytes), header_(header) {}

  bool read(char c[], int n) override {
    const auto count = static_cast<std::uint64_t>(std::max(n, 0));
    if (at_ > bytes_.size() || count > bytes_.size() - at_) throw std::runtime_error("the file ends early");
    const auto target = std::as_writable_bytes(std::span(c, static_cast<std::size_t>(count)));
    if (Status read = bytes_.read(at_, target); !read) {
      error_ = read.error();
      throw std::runtime_error("reading failed");
    }
    if (at_ < header_.size()) {
      const std::uint64_t changed = std::min<std::uint64_t>(count, header_.size() - at_);
      std::copy_n(header_.begin() + static_cast<std::ptrdiff_t>(at_), changed, target.begin());
    }
    at_ += count;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t pos) override { at_ = pos; }
  void clear() override {}

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const ByteSource& bytes_;
  std::span<const std::byte> header_;
  std::uint64_t at_ = 0;
  std::optional<Error> error_;
};

class Reader final : public ExrReader {
 public:
  Reader(std::shared_ptr<const ByteSource> bytes, ParsedExrHeader parsed)
      : bytes_(std::move(bytes)), parsed_(std::move(parsed)) {}

  [[nodiscard]] const ExrHeader& header() const override { return parsed_.header; }

  [[nodiscard]] Status read(std::span<const std::string> channels, bool half, std::span<std::byte> target) override {
    assert(target.size() ==
           std::uint64_t{parsed_.header.width} * parsed_.header.height * channels.size() * number_size(half));
    SourceStream stream(*bytes_, parsed_.plain);
    try {
      Imf::InputFile file(stream, 0);
      const Imath::Box2i window = file.header().dataWindow();
      file.setFrameBuffer(frame_buffer(channels, half, target.data(), window));
      file.readPixels(window.min.y, window.max.y);
    } catch (const std::bad_alloc&) {
      return unsupported("OpenEXR: too little memory for this image");
    } catch (const std::exception& thrown) {
      if (stream.error()) return *stream.error();
      return library_error(thrown);
    }
    return ok_status();
  }

 private:
  std::shared_ptr<const ByteSource> bytes_;
  ParsedExrHeader parsed_;
};

/// Gathers the many small pieces that the library writes.
class SinkStream final : public Imf::OStream {
 public:
  explicit SinkStream(ByteSink& sink) : Imf::OStream("image"), sink_(sink) {}

  void write(const char c[], int n) override {
    const auto bytes = std::as_bytes(std::span(c, static_cast<std::size_t>(std::max(n, 0))));
    gathered_.insert(gathered_.end(), bytes.begin(), bytes.end());
    if (!held_ && gathered_.size() >= kPiece) pass_on();
  }
  std::uint64_t tellp() override { return start_ + gathered_.size(); }
  void seekp(std::uint64_t pos) override {
    if (pos == tellp()) return;
    pass_on();
    start_ = pos;
  }

  /// Everything from the start of the file on, before release().
  [[nodiscard]] std::span<const std::byte> held() const { return gathered_; }
  void release() { held_ = false; }

  /// Throws where the sink refuses, which stops the library; `status` tells why.
  void pass_on() {
    if (status_) status_ = sink_.write(start_, gathered_);
    start_ += gathered_.size();
    gathered_.clear();
    if (!status_) throw std::runtime_error("writing failed");
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 20U;

  ByteSink& sink_;
  std::vector<std::byte> gathered_;
  std::uint64_t start_ = 0;
  bool held_ = true;
  Status status_ = ok_status();
};

class Writer final : public ExrWriter {
 public:
  Writer(ByteSink& sink, const Image& image) : sink_(sink), stream_(sink), image_(image) {}

  Status begin() {
    const Imath::Box2i window({0, 0}, {static_cast<int>(image_.width) - 1, static_cast<int>(image_.height) - 1});
    Imf::Header header(window, window);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const std::string& name : image_.channels) {
      header.channels().insert(name, Imf::Channel(image_.half ? Imf::HALF : Imf::FLOAT));
    }
    header.insert(image_.attribute, Imf::StringAttribute(image_.text));
    return guarded([&] {
      file_.emplace(stream_, header, 0);
      text_offset_ = offset_of_text();
      stream_.release();
    });
  }

  [[nodiscard]] Status write_row(std::span<const std::byte> numbers) override {
    assert(numbers.size() == image_.width * image_.channels.size() * number_size(image_.half));
    return guarded([&] {
      const int y = file_->currentScanLine();
      const Imath::Box2i window({0, y}, {static_cast<int>(image_.width) - 1, y});
      file_->setFrameBuffer(frame_buffer(image_.channels, image_.half, numbers.data(), window));
      file_->writePixels(1);
    });
  }

  [[nodiscard]] Status finish(std::string_view text) override {
    assert(text.size() == image_.text.size());
    Status finished = guarded([&] {
      file_.reset();  // writes where each block lies
      stream_.pass_on();
    });
    if (!finished) return finished;
    return sink_.write(text_offset_, std::as_bytes(std::span(text.data(), text.size())));
  }

 private:
  template <class Work>
  Status guarded(const Work& work) {
    try {
      work();
    } catch (const std::bad_alloc&) {
      return unsupported("OpenEXR: too little memory for this image");
    } catch (const std::exception& thrown) {
      if (!stream_.status()) return stream_.status();
      return library_error(thrown);
    }
    return stream_.status();
  }

  [[nodiscard]] std::uint64_t offset_of_text() const {
    const std::string_view written(reinterpret_cast<const char*>(stream_.held().data()), stream_.held().size());
    std::string start = image_.attribute;
    start += '\0';
    start += "string";
    start += '\0';
    return written.find(start) + start.size() + sizeof(std::int32_t);
  }

  ByteSink& sink_;
  SinkStream stream_;
  Image image_;
  std::optional<Imf::OutputFile> file_;  // ends before the stream that it writes to
  std::uint64_t text_offset_ = 0;
};

}  // namespace

Result<std::unique_ptr<ExrReader>> ExrReader::open(std::shared_ptr<const ByteSource> bytes,
                                                   std::string_view attribute) {
  Result<ParsedExrHeader> parsed = parse_exr_header(*bytes, attribute);
  if (!parsed) return parsed.error();
  return std::unique_ptr<ExrReader>(std::make_unique<Reader>(std::move(bytes), *std::move(parsed)));
}

Status ExrWriter::check(const Image& image) {
  if (image.width > kMostBytes || image.height > kMostBytes) {
    return unsupported(fmt::format("an image of {} x {} pixels; an OpenEXR file has at most 2^31 - 1 along a side",
                                   image.width, image.height));
  }
  const std::uint64_t row = image.width * image.channels.size() * number_size(image.half);
  if (row > kMostBytes / kRowsOfBlock) {
    return unsupported(fmt::format("rows of {} bytes; OpenEXR packs 16 rows at a time into at most 2^31 - 1", row));
  }
  std::set<std::string> seen;
  for (const std::string& name : image.channels) {
    const bool sound = !name.empty() && name.size() <= kLongestName && name.find('\0') == std::string::npos;
    if (!sound || !seen.insert(name).second) {
      return unsupported(
          "a channel whose name is empty, longer than 255 bytes or that of another one; OpenEXR files tell channels by "
          "name");
    }
  }
  return ok_status();
}

Result<std::unique_ptr<ExrWriter>> ExrWriter::create(ByteSink& sink, const Image& image) {
  auto writer = std::make_unique<Writer>(sink, image);
  if (Status begun = writer->begin(); !begun) return begun.error();
  return std::unique_ptr<ExrWriter>(std::move(writer));
}

}  // namespace sbrdf::internal
