#include "converters/files/sliced/bundle_file.h"

#include <array>
#include <utility>

#include "converters/files/sliced/sliced.h"
#include "formats/sbrdf/bundle.h"

namespace sbrdf::internal {
namespace {

/// A material with the bundle that its body lies in.
class MaterialFile final : public ByteSource {
 public:
  MaterialFile(std::shared_ptr<const ByteSource> bundle, std::unique_ptr<ByteSource> file)
      : bundle_(std::move(bundle)), file_(std::move(file)) {}

  [[nodiscard]] std::uint64_t size() const override { return file_->size(); }
  [[nodiscard]] std::uint64_t stored_size() const override { return file_->stored_size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    return file_->read(offset, target);
  }

 private:
  std::shared_ptr<const ByteSource> bundle_;
  std::unique_ptr<ByteSource> file_;
};

constexpr std::array kOptions = {
    OptionSpec{.name = "material",
               .use = OptionUse::kRead,
               .unit = "NAME",
               .meaning = "Which material of the bundle, the same as BUNDLE.sbrdfz:NAME"},
};

}  // namespace

Result<std::shared_ptr<const ByteSource>> material_of_bundle(std::shared_ptr<const ByteSource> bundle,
                                                             std::string_view name, const MemoryLimit& limit) {
  const Result<BundleReader> reader = BundleReader::open(*bundle, limit);
  if (!reader) return reader.error();
  Result<std::unique_ptr<ByteSource>> file = reader->material(name);
  if (!file) return file.error();
  return std::shared_ptr<const ByteSource>(std::make_shared<MaterialFile>(std::move(bundle), *std::move(file)));
}

Result<std::unique_ptr<BrdfSource>> open_bundle(std::shared_ptr<const ByteSource> bundle, const Options& options) {
  Result<std::shared_ptr<const ByteSource>> file =
      material_of_bundle(std::move(bundle), options.text("material").value_or(""), options.memory);
  if (!file) return file.error();
  return open_sliced(*std::move(file), within(options.memory));
}

std::span<const OptionSpec> bundle_options() { return kOptions; }

}  // namespace sbrdf::internal
