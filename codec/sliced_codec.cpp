#include "codec/sliced_codec.h"

#include <algorithm>
#include <cstring>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/container.h"

namespace sbrdf {
namespace {

constexpr std::size_t kMaxChannels = 4096;

template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

template <class T>
Result<std::vector<T>> array_of(const Container& container, const char* name) {
  const auto bytes = container.find(name);
  if (bytes.size() % sizeof(T) != 0) {
    return Error{ErrorCode::kInvalidFile, std::string("chunk ") + name + ": not a whole number of entries", {}};
  }
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

enum SymmetryBits : std::uint8_t { kIsotropicBit = 1, kMirrorXBit = 2, kMirrorYBit = 4 };

std::vector<std::byte> encode_frame(const FrameSpec& frame) {
  ByteWriter out;
  out.number(static_cast<std::uint8_t>(frame.id));
  const Symmetries& symmetries = frame.symmetries;
  out.number(static_cast<std::uint8_t>((symmetries.isotropic ? kIsotropicBit : 0) |
                                       (symmetries.mirror_x ? kMirrorXBit : 0) |
                                       (symmetries.mirror_y ? kMirrorYBit : 0)));
  for (const Axis& axis : frame.axes) {
    out.number(static_cast<std::uint16_t>(axis.nodes_deg.size()));
    for (const double node : axis.nodes_deg) out.number(node);
  }
  return std::move(out).take();
}

Result<FrameSpec> decode_frame(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  FrameSpec frame;
  frame.id = static_cast<FrameId>(in.u8());
  const std::uint8_t bits = in.u8();
  frame.symmetries = {(bits & kIsotropicBit) != 0, (bits & kMirrorXBit) != 0, (bits & kMirrorYBit) != 0};
  const FrameGeometry* known = find_geometry(frame.id);
  if (!in.ok() || known == nullptr || bits > (kIsotropicBit | kMirrorXBit | kMirrorYBit)) {
    return Error{ErrorCode::kUnsupported, "chunk FRAM: unknown frame or symmetry", {}};
  }
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    frame.axes[axis].name = known->axis_names()[axis];
    const std::uint16_t count = in.u16();
    for (std::uint16_t k = 0; k < count && in.ok(); ++k) frame.axes[axis].nodes_deg.push_back(in.f64());
  }
  if (!in.ok() || in.remaining() != 0) return Error{ErrorCode::kInvalidFile, "chunk FRAM: wrong size", {}};
  return frame;
}

std::vector<std::byte> encode_values(const SlicedBrdf& sliced) {
  ByteWriter out;
  out.number(static_cast<std::uint8_t>(sliced.domain.kind));
  out.number(static_cast<std::uint16_t>(sliced.channel_count()));
  for (const std::string& name : sliced.channels) {
    out.number(static_cast<std::uint16_t>(name.size()));
    out.text(name);
  }
  for (const float v : sliced.domain.reference) out.number(v);
  for (const float v : sliced.domain.floor) out.number(v);
  return std::move(out).take();
}

Status decode_values(std::span<const std::byte> bytes, SlicedBrdf& sliced) {
  ByteReader in(bytes);
  sliced.domain.kind = static_cast<DomainKind>(in.u8());
  const std::uint16_t channels = in.u16();
  if (channels == 0 || channels > kMaxChannels) {
    return Error{ErrorCode::kInvalidFile, "chunk VALU: " + std::to_string(channels) + " channels", {}};
  }
  for (std::uint16_t c = 0; c < channels && in.ok(); ++c) sliced.channels.push_back(in.text(in.u16()));
  if (sliced.domain.kind == DomainKind::kLog) {
    for (std::uint16_t c = 0; c < channels; ++c) sliced.domain.reference.push_back(in.number<float>());
    for (std::uint16_t c = 0; c < channels; ++c) sliced.domain.floor.push_back(in.number<float>());
  }
  if (!in.ok() || in.remaining() != 0) return Error{ErrorCode::kInvalidFile, "chunk VALU: wrong size", {}};
  return ok_status();
}

// Fractions are 16 bits wide, intervals of a slice fewer than 2^16: two planes of halves pack better than pairs.
std::vector<std::uint16_t> split_positions(const std::vector<SamplePosition>& positions) {
  std::vector<std::uint16_t> planes(2 * positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    planes[k] = static_cast<std::uint16_t>(positions[k].interval);
    planes[positions.size() + k] = static_cast<std::uint16_t>(positions[k].fraction);
  }
  return planes;
}

std::vector<SamplePosition> join_positions(const std::vector<std::uint16_t>& planes) {
  const std::size_t count = planes.size() / 2;
  std::vector<SamplePosition> positions;
  for (std::size_t k = 0; k < count; ++k) positions.push_back({planes[k], planes[count + k]});
  return positions;
}

std::vector<std::byte> encode_guide(const Guide& guide) {
  ByteWriter out;
  out.number(guide.ratio);
  out.number(static_cast<std::uint32_t>(guide.places.size()));
  const std::vector<std::uint16_t> planes = split_positions(guide.places);
  out.bytes(std::as_bytes(std::span(planes)));
  out.bytes(std::as_bytes(std::span(guide.values)));
  return std::move(out).take();
}

Result<Guide> decode_guide(std::span<const std::byte> bytes, std::size_t channels) {
  ByteReader in(bytes);
  Guide guide;
  guide.ratio = in.f64();
  const std::uint64_t count = in.u32();
  if (!in.ok() || in.remaining() != count * (2 * sizeof(std::uint16_t) + channels * sizeof(float))) {
    return Error{ErrorCode::kInvalidFile, "chunk GUID: wrong size", {}};
  }
  std::vector<std::uint16_t> planes(2 * count);
  for (std::uint16_t& half : planes) half = in.u16();
  guide.places = join_positions(planes);
  guide.values.resize(count * channels);
  for (float& value : guide.values) value = in.number<float>();
  return guide;
}

// Away from the poles at most eight lattice points are one crossing. Keeps a small file from asking for a huge lattice.
double least_crossing_count(const FrameSpec& frame) {
  double count = 1.0 / 8;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::size_t nodes = frame.axes[axis].nodes_deg.size();
    if (nodes > 0) count *= static_cast<double>(axis <= kDiagonal ? nodes : nodes - 1);
  }
  return count;
}

}  // namespace

std::vector<std::byte> encode_sliced(const SlicedBrdf& sliced) {
  const auto metadata = std::as_bytes(std::span(sliced.metadata.data(), sliced.metadata.size()));
  std::vector<Chunk> chunks = {
      {"FRAM", encode_frame(sliced.frame)},         {"VALU", encode_values(sliced)},
      {"META", {metadata.begin(), metadata.end()}}, {"CROS", bytes_of(sliced.crossing_values)},
      {"CNTS", bytes_of(sliced.sample_counts)},     {"POSI", bytes_of(split_positions(sliced.positions))},
      {"SAMP", bytes_of(sliced.sample_values)},
  };
  if (sliced.guide) chunks.push_back({"GUID", encode_guide(*sliced.guide)});
  return emit_container(chunks);
}

Result<DecodedSliced> decode_sliced(std::span<const std::byte> bytes) {
  Result<Container> container = parse_container(bytes);
  if (!container) return container.error();
  for (const char* name : {"FRAM", "VALU", "META", "CROS", "CNTS", "POSI", "SAMP"}) {
    if (!container->has(name)) return Error{ErrorCode::kInvalidFile, std::string("chunk ") + name + " is missing", {}};
  }
  Result<FrameSpec> frame = decode_frame(container->find("FRAM"));
  if (!frame) return frame.error();
  SlicedBrdf sliced;
  sliced.frame = *std::move(frame);
  if (Status status = decode_values(container->find("VALU"), sliced); !status) return status.error();
  const auto metadata = container->find("META");
  sliced.metadata.assign(reinterpret_cast<const char*>(metadata.data()), metadata.size());
  auto crossings = array_of<float>(*container, "CROS");
  auto counts = array_of<std::uint32_t>(*container, "CNTS");
  auto planes = array_of<std::uint16_t>(*container, "POSI");
  auto samples = array_of<float>(*container, "SAMP");
  for (const Error* error : {crossings ? nullptr : &crossings.error(), counts ? nullptr : &counts.error(),
                             planes ? nullptr : &planes.error(), samples ? nullptr : &samples.error()}) {
    if (error != nullptr) return *error;
  }
  sliced.crossing_values = *std::move(crossings);
  sliced.sample_counts = *std::move(counts);
  sliced.sample_values = *std::move(samples);
  if (planes->size() % 2 != 0) return Error{ErrorCode::kInvalidFile, "chunk POSI: not a whole number of entries", {}};
  sliced.positions = join_positions(*planes);
  if (container->has("GUID")) {
    Result<Guide> guide = decode_guide(container->find("GUID"), sliced.channel_count());
    if (!guide) return guide.error();
    sliced.guide = *std::move(guide);
  }
  if (least_crossing_count(sliced.frame) * static_cast<double>(sliced.channel_count()) >
      static_cast<double>(sliced.crossing_values.size())) {
    return Error{ErrorCode::kInvalidFile, "chunk CROS: fewer values than the frame has crossings", {}};
  }
  Result<Lattice> lattice = build_lattice(sliced.frame);
  if (!lattice) return lattice.error();
  if (Status status = check_sliced(sliced, *lattice); !status) return status.error();
  return DecodedSliced{std::move(sliced), *std::move(lattice),
                       std::to_string(container->major) + "." + std::to_string(container->minor)};
}

}  // namespace sbrdf
