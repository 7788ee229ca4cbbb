#include "formats/sbrdf/metadata.h"

#include "formats/sbrdf/zstd_frame.h"

namespace sbrdf::internal {

std::string_view metadata_dictionary() {
  return R"("findings":[{"what":"negative stored rgb values","count":,"total":}]"symmetrised":true,)"
         R"("refinement":"measured","domain":"linear","colour":"channels as in the source, linear",)"
         R"({"source":{"format":"merl","description":"MERL table, isotropic, half/difference angles","sha256":")"
         R"({"source":{"format":"kurt","description":"Kurt model , 2 lobes"},"command":"sbrdf convert kurt:)"
         R"({"source":{"format":"rgl","description":"RGL material, isotropic, RGB","sha256":")"
         R"("command":"sbrdf convert .bsdf .sbrdf --samples --precision 0.1% --placement 14/36",)"
         R"("quantity":"f_r, 1/sr, without cosine","colour":"channels as in the source, linear",)"
         R"("precision_percent":0.1,"symmetrised":false,"reciprocity_residual_percent":0.0,"refinement":"true",)"
         R"("zero_values":0,"negative_values":0,"error":{"mre_percent":0.,"rel_l1_percent":0.,"directions":12000,)"
         R"("measured_on":"random directions that took no part in any choice, theta up to 80 degrees"}})";
}

std::vector<std::byte> pack_metadata(std::string_view text) {
  return pack_bytes(std::as_bytes(std::span(text)), metadata_dictionary());
}

std::optional<std::string> unpack_metadata(std::span<const std::byte> packed, std::size_t size) {
  const std::optional<std::vector<std::byte>> bytes = unpack_bytes(packed, size, metadata_dictionary());
  if (!bytes) return {};
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace sbrdf::internal
