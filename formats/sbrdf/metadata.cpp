#include "formats/sbrdf/metadata.h"

#include <zlib.h>

#include <algorithm>
#include <new>

namespace sbrdf::internal {
namespace {

constexpr int kRaw = -15;  // a window of 2^15 bytes, no header, no checksum
constexpr int kMostMemory = 9;

const Bytef* bytes_of(std::string_view text) { return reinterpret_cast<const Bytef*>(text.data()); }

}  // namespace

std::string_view metadata_dictionary() {
  return R"("zero_values":0,"negative_values":0,"symmetrised":true,"reciprocity_residual_percent":0.0,)"
         R"("error_before_rounding":{"coded_before_percent":[0.1],"error_of_whole":{"extracted":{"theta_max_deg":)"
         R"(,"max_level":,"difference_from_whole_percent":"extracted_before":[{"values_all_zero":true)"
         R"("findings":[{"what":"negative stored rgb values","count":,"total":}],"refinement":"measured",)"
         R"("description":"MERL table, isotropic, half/difference angles","description":"Kurt model , 2 lobes",)"
         R"("command":"sbrdf convert kurt:.bsdf .sbrdf --metadata full --samples --precision 0.1% --placement 14/36",)"
         R"("symmetrised":false,"refinement":"true","zero_values":0,"negative_values":0,"directions":12000,)"
         R"("measured_on":"random directions that took no part in any choice, theta up to 80 degrees"}})"
         R"({"source":{"format":"merl","sha256":"{"source":{"format":"kurt"},"error":{"mre_percent":0.)"
         R"({"source":{"format":"rgl","sha256":""},"reciprocity_residual_percent":)"
         R"(,"error":{"mre_percent":0.,"rel_l1_percent":0.}})";
}

std::vector<std::byte> pack_metadata(std::string_view text) {
  z_stream stream{};
  const std::string_view dictionary = metadata_dictionary();
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kRaw, kMostMemory, Z_DEFAULT_STRATEGY) != Z_OK ||
      deflateSetDictionary(&stream, bytes_of(dictionary), static_cast<uInt>(dictionary.size())) != Z_OK) {
    throw std::bad_alloc();  // the only way they can fail
  }
  std::vector<std::byte> packed(deflateBound(&stream, static_cast<uLong>(text.size())));
  stream.next_in = const_cast<Bytef*>(bytes_of(text));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);  // ends: there is room for all
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

std::optional<std::string> unpack_metadata(std::span<const std::byte> packed, std::size_t size) {
  z_stream stream{};
  const std::string_view dictionary = metadata_dictionary();
  if (inflateInit2(&stream, kRaw) != Z_OK ||
      inflateSetDictionary(&stream, bytes_of(dictionary), static_cast<uInt>(dictionary.size())) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string text(size, '\0');
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(size);
  const bool ended = inflate(&stream, Z_FINISH) == Z_STREAM_END;
  const bool exact = ended && stream.total_out == size && stream.avail_in == 0;
  inflateEnd(&stream);
  return exact ? std::optional(std::move(text)) : std::nullopt;
}

}  // namespace sbrdf::internal
