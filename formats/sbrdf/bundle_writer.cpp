#include <algorithm>
#include <utility>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/head_packing.h"

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

/// A material on its way into a bundle.
struct Packed {
  BundleEntry entry;
  Bytes head;
  Bytes stored;
  std::span<const std::byte> body;
};

// What is dropped here is what front_of_file puts back: only files for which that gives the same bytes may pass.
Result<Packed> take_apart(const BundleInput& input) {
  const MemorySource source(input.file);
  const Result<ContainerHead> container = read_head(source);
  if (!container) return container.error();
  Packed packed;
  packed.body = input.file.subspan(static_cast<std::size_t>(container->chunks_offset()));
  packed.entry = {input.name, static_cast<std::uint32_t>(container->index.size()), 0, packed.body.size(), 0};
  ByteWriter head;
  head.number(container->major);
  head.number(container->minor);
  head.bytes(container->index);
  packed.head = std::move(head).take();
  return packed;
}

Result<std::vector<Packed>> take_all_apart(std::span<const BundleInput> inputs) {
  if (inputs.empty()) return usage_error("a bundle needs at least one material");
  if (inputs.size() > kMostMaterials) return unsupported("a bundle has at most 2^20 materials");
  std::vector<Packed> all;
  for (const BundleInput& input : inputs) {
    if (Status allowed = check_material_name(input.name); !allowed) return allowed.error();
    Result<Packed> packed = take_apart(input);
    if (!packed) {
      Error error = packed.error();
      error.message = "material '" + input.name + "': " + error.message;
      return error;
    }
    all.push_back(*std::move(packed));
  }
  std::sort(all.begin(), all.end(), [](const Packed& a, const Packed& b) { return a.entry.name < b.entry.name; });
  const auto twice = std::adjacent_find(all.begin(), all.end(),
                                        [](const Packed& a, const Packed& b) { return a.entry.name == b.entry.name; });
  if (twice != all.end()) return usage_error("two materials are named '" + twice->entry.name + "'");
  return all;
}

/// Compresses the heads; gives the dictionary.
Bytes pack_heads(std::vector<Packed>& all) {
  std::vector<Bytes> heads;
  heads.reserve(all.size());
  for (Packed& packed : all) heads.push_back(std::move(packed.head));
  const auto pack = [&](std::span<const std::byte> dictionary) {
    HeadPacker packer(dictionary);
    bool compressed = false;
    for (std::size_t k = 0; k < all.size(); ++k) {
      all[k].stored = packer.pack(heads[k]);
      all[k].entry.stored_size = static_cast<std::uint32_t>(all[k].stored.size());
      compressed = compressed || all[k].entry.is_compressed();
    }
    return compressed;
  };
  Bytes dictionary = choose_dictionary(heads);
  if (!pack(dictionary)) dictionary.clear();
  return dictionary;
}

Bytes emit_index(const std::vector<Packed>& all, std::size_t dictionary_size) {
  ByteWriter out;
  out.count(all.size());
  out.count(dictionary_size);
  for (const Packed& packed : all) {
    out.count(packed.entry.name.size());
    out.text(packed.entry.name);
    out.count(packed.entry.index_size);
    out.count(packed.entry.stored_size);
    out.count(packed.entry.body_size);
  }
  return std::move(out).take();
}

/// Header and its checksum.
Bytes emit_header(std::span<const std::byte> index, std::uint64_t file_size) {
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kBundleMagic)));
  out.number(kBundleMajor);
  out.number(kBundleMinor);
  out.number(static_cast<std::uint32_t>(index.size()));
  out.number(file_size);
  out.number(checksum(index));
  Bytes header;
  append_chunk(header, std::move(out).take());
  return header;
}

}  // namespace

Result<std::vector<std::byte>> emit_bundle(std::span<const BundleInput> inputs) {
  Result<std::vector<Packed>> all = take_all_apart(inputs);
  if (!all) return all.error();
  const Bytes dictionary = pack_heads(*all);
  const Bytes index = emit_index(*all, dictionary.size());
  if (index.size() > kMaxBundleIndexSize) return unsupported("the index is larger than 2^24 bytes");
  std::uint64_t file_size =
      kBundleHeaderSize + index.size() + (dictionary.empty() ? 0 : dictionary.size() + kChecksumSize);
  for (const Packed& packed : *all) file_size += packed.entry.bundled_size();
  Bytes file = emit_header(index, file_size);
  const auto append = [&file](std::span<const std::byte> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
  };
  file.reserve(file_size);
  append(index);
  append_chunk(file, dictionary);
  for (const Packed& packed : *all) {
    append_chunk(file, packed.stored);
    append(packed.body);
  }
  return file;
}

}  // namespace sbrdf::internal
