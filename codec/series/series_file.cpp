#include "codec/series/series_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "codec/file/index.h"
#include "codec/series/coefficient_coder.h"
#include "formats/core/byte_reader.h"
#include "formats/sbrdf/channel_names.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/metadata.h"

namespace sbrdf::internal {
namespace {

enum FrameBits : std::uint8_t { kFrameMask = 0x0F, kIsotropic = 16, kMirrorX = 32, kMirrorY = 64 };
enum PartBits : std::uint8_t { kNegative = 1, kMetadata = 4, kThetaMax = 8, kKnown = 13 };
constexpr std::int64_t kFarthestStep = 8 * 160;  // of the bound, in eighths of the logarithm
constexpr double kMostLog = 8 * 85;              // of reference and bound together: exp(85) is a float
constexpr double kLog2 = 0.69314718055994531;
constexpr std::int32_t kFarthestColour = 1 << 20;
constexpr std::size_t kMostHead = 16;

void put_colours(ByteWriter& out, const SeriesBrdf& brdf) {
  const std::size_t channels = brdf.channel_count();
  for (std::size_t c = 0; c + 1 < channels; ++c) out.signed_count(brdf.mean_colour[c]);
  if (brdf.component_count == 0) return;
  if (channels == 3) return out.number(brdf.colour_turn);
  for (const auto& component : brdf.components) {
    for (const std::int8_t part : component) out.number(part);
  }
}

/// The last one follows from the others: the mean colour has the mean 1.
Status take_colours(ByteReader& in, SeriesBrdf& brdf) {
  const std::size_t channels = brdf.channel_count();
  auto last = static_cast<std::int64_t>(static_cast<double>(channels) * kColourUnit);
  for (std::size_t c = 0; c + 1 < channels && in.ok(); ++c) {
    const std::int64_t part = in.signed_count(33);
    if (std::abs(part) > kFarthestColour) return refuse_sliced("SD-6", "a mean colour that no mean can have");
    last -= part;
    brdf.mean_colour.push_back(static_cast<std::int32_t>(part));
  }
  if (!in.ok()) return ok_status();
  brdf.mean_colour.push_back(static_cast<std::int32_t>(last));
  if (brdf.component_count == 0) return ok_status();
  if (channels == 3) {
    brdf.colour_turn = in.u8();
    return ok_status();
  }
  for (std::size_t j = 0; j < brdf.component_count && in.ok(); ++j) {
    std::vector<std::int8_t>& component = brdf.components.emplace_back();
    for (std::size_t c = 0; c < channels; ++c) component.push_back(in.number<std::int8_t>());
  }
  return ok_status();
}

void put_fixed(ByteWriter& out, const SeriesBrdf& brdf) {
  const auto theta_max = static_cast<std::uint64_t>(std::lround(brdf.warp.theta_max_deg * 100));
  const bool usual = brdf.warp.theta_max_deg == kPaperThetaMaxDeg;
  out.number(static_cast<std::uint8_t>(kDenseFrame | (brdf.symmetries.isotropic ? kIsotropic : 0) |
                                       (brdf.symmetries.mirror_x ? kMirrorX : 0) |
                                       (brdf.symmetries.mirror_y ? kMirrorY : 0)));
  out.number(static_cast<std::uint8_t>((brdf.negative ? kNegative : 0) | (brdf.metadata.empty() ? 0 : kMetadata) |
                                       (usual ? 0 : kThetaMax)));
  if (!usual) out.count(theta_max);
  put_channel_names(out, brdf.channels);
  out.number(static_cast<std::uint8_t>(brdf.component_count | static_cast<std::uint32_t>(brdf.fineness) << 4U));
  out.count(brdf.shape.theta_h);
  out.count(brdf.shape.theta_d);
  out.count(brdf.shape.phi_d);
  if (!brdf.symmetries.isotropic) out.count(brdf.shape.phi_h);
  out.number(brdf.warp.width_step);
  out.number(brdf.warp.power_step);
  out.signed_count(brdf.reference_step);
  out.signed_count(brdf.most_step);
  out.number(brdf.coefficient_step);
}

Status take_frame(ByteReader& in, SeriesBrdf& brdf, std::uint8_t& parts) {
  const std::uint8_t frame = in.u8();
  parts = in.u8();
  if (!in.ok()) return ok_status();
  if ((frame & kFrameMask) != kDenseFrame) return unsupported("[SB-2-2] unknown frame");
  if (frame >= 128) return unsupported("[SB-2-3] unknown symmetry");
  if ((parts & ~kKnown) != 0) return unsupported("[SD-1] unknown parts");
  brdf.symmetries = {(frame & kIsotropic) != 0, (frame & kMirrorX) != 0, (frame & kMirrorY) != 0};
  brdf.negative = (parts & kNegative) != 0;
  const std::uint64_t theta_max = (parts & kThetaMax) != 0 ? in.count(32) : 8000;
  if (theta_max == 0 || theta_max > 9000) return refuse_sliced("SD-2", "theta_max is not within 0.01 and 90 degrees");
  brdf.warp.theta_max_deg = static_cast<double>(theta_max) / 100;
  return take_channel_names(in, brdf.channels);
}

Status take_shape(ByteReader& in, SeriesBrdf& brdf) {
  const std::uint8_t counts = in.u8();
  brdf.component_count = counts & 15U;
  brdf.fineness = counts >> 4U;
  const auto taken = [&] { return static_cast<std::uint32_t>(in.count(32)); };
  brdf.shape.theta_h = taken();
  brdf.shape.theta_d = taken();
  brdf.shape.phi_d = taken();
  if (!brdf.symmetries.isotropic) brdf.shape.phi_h = taken();
  brdf.warp.width_step = in.u8();
  brdf.warp.power_step = in.u8();
  const std::int64_t reference = in.signed_count(33);
  const std::int64_t most = in.signed_count(33);
  brdf.coefficient_step = in.u8();
  if (!in.ok()) return ok_status();
  const std::size_t components =
      brdf.channel_count() == 3 ? 2 : std::min<std::size_t>(kMostComponents, brdf.channel_count() - 1);
  if (brdf.component_count > components) return refuse_sliced("SD-3", "more components than colours have");
  const SeriesShape& shape = brdf.shape;
  if (std::min({shape.theta_h, shape.theta_d, shape.phi_d}) < 2 || (!brdf.symmetries.isotropic && shape.phi_h < 2)) {
    return refuse_sliced("SD-3", "less than two functions along an axis");
  }
  if (brdf.fineness == 0) return refuse_sliced("SD-3", "a table without nodes");
  if (std::abs(reference) > 8 * 100) return refuse_sliced("SD-4", "a reference that is no float");
  if (std::abs(most) > kFarthestStep || static_cast<double>(reference) * kLog2 + static_cast<double>(most) > kMostLog) {
    return refuse_sliced("SD-4", "a bound of the mean that is no float");
  }
  brdf.reference_step = static_cast<std::int32_t>(reference);
  brdf.most_step = static_cast<std::int32_t>(most);
  return ok_status();
}

Status take_metadata(ByteReader& in, SeriesBrdf& brdf) {
  const std::uint64_t size = in.count(32);
  const std::uint64_t packed = in.count(32);
  if (in.ok() && size > kMaxMetadataSize) return refuse_sliced("SB-2-15", "more metadata than can be");
  const std::span<const std::byte> bytes = in.bytes(packed);
  if (!in.ok()) return ok_status();
  std::optional<std::string> text = unpack_metadata(bytes, static_cast<std::size_t>(size));
  if (!text) return refuse_sliced("SB-8-5", "the metadata do not unpack to their size");
  brdf.metadata = *std::move(text);
  return ok_status();
}

Result<SeriesBrdf> parse_series(std::span<const std::byte> index, std::uint32_t most_level) {
  ByteReader in(index);
  SeriesBrdf brdf;
  std::uint8_t parts = 0;
  if (Status status = take_frame(in, brdf, parts); !status) return status.error();
  if (Status status = take_shape(in, brdf); !status) return status.error();
  if (Status status = take_colours(in, brdf); !status) return status.error();
  std::vector<std::uint32_t> counts;
  for (std::size_t f = 0; f < brdf.field_count(); ++f) counts.push_back(static_cast<std::uint32_t>(in.count(32)));
  if (in.ok() && (parts & kMetadata) != 0) {
    if (Status status = take_metadata(in, brdf); !status) return status.error();
  }
  if (!in.ok()) return refuse_sliced("SB-2-1", "the index ends early");
  const Result<SeriesBasis> basis = make_basis(brdf.shape, brdf.symmetries);
  if (!basis) return basis.error();
  const auto more = [&](std::uint32_t count) { return count > basis->terms.size(); };
  if (std::any_of(counts.begin(), counts.end(), more)) return refuse_sliced("SD-5", "more coefficients than terms");
  const std::span<const std::byte> stream = in.bytes(in.remaining());
  if (!stream.empty() && stream.back() == std::byte{0}) return refuse_sliced("SD-5", "a stream that ends with 0");
  auto coefficients = decode_coefficients(*basis, stream, counts, most_level);
  if (!coefficients) return refuse_sliced("SD-5", coefficients.error().message);
  brdf.coefficients = *std::move(coefficients);
  return brdf;
}

}  // namespace

bool is_series_file(const ByteSource& source) {
  const Result<std::vector<std::byte>> start = read_start(source, kMostHead);
  if (!start || !is_container(*start)) return false;
  ByteReader in(*start);
  in.bytes(kContainerMagic.size() + 2);
  in.count(32);
  return in.remaining() > 0 && (in.u8() & kFrameMask) == kDenseFrame;
}

std::vector<std::byte> encode_series(const SeriesBrdf& brdf) {
  ByteWriter out;
  put_fixed(out, brdf);
  put_colours(out, brdf);
  for (const auto& field : brdf.coefficients) out.count(coded_terms(field));
  if (!brdf.metadata.empty()) {
    const std::vector<std::byte> packed = pack_metadata(brdf.metadata);
    out.count(brdf.metadata.size());
    out.count(packed.size());
    out.bytes(packed);
  }
  const Result<SeriesBasis> basis = make_basis(brdf.shape, brdf.symmetries);
  out.bytes(code_coefficients(*basis, brdf.coefficients));
  return emit_head(std::move(out).take());
}

Result<SeriesBrdf> decode_series(const ByteSource& source, std::uint32_t most_level) {
  const Result<ContainerHead> head = read_head(source);
  if (!head) return head.error();
  Result<SeriesBrdf> brdf = parse_series(head->index, most_level);
  if (brdf && head->minor <= kContainerMinor && source.size() != head->chunks_offset()) {
    return refuse_sliced("SD-7", "the file goes on behind its head");
  }
  return brdf;
}

}  // namespace sbrdf::internal
