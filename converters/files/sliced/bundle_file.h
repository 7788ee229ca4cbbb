#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "converters/files/format.h"

namespace sbrdf::internal {

/// The bytes of one material of a bundle (specs/sbrdfz.md): a sliced file. Keeps the bundle for as long as it lives.
/// kUsage, with the names nearest to it, where there is none of that name; kUnsupported where it unpacks to more than
/// `limit` allows.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> material_of_bundle(std::shared_ptr<const ByteSource> bundle,
                                                                           std::string_view name,
                                                                           const MemoryLimit& limit = {});

/// Opens the material that the option "material" names: the row of the format table. kUsage, with some names that
/// there are, where the option is missing.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_bundle(std::shared_ptr<const ByteSource> bundle,
                                                              const Options& options);
[[nodiscard]] std::span<const OptionSpec> bundle_options();

}  // namespace sbrdf::internal
