#include "formats/sbrdf/head_packing.h"

#include <zdict.h>
#include <zstd.h>

#include <algorithm>
#include <array>

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

constexpr int kLevel = 19;
constexpr std::array<std::byte, 4> kFrameMagic = {std::byte{0x28}, std::byte{0xB5}, std::byte{0x2F}, std::byte{0xFD}};

// A choice that looks at more heads than these takes longer and is not better.
constexpr std::size_t kMostSamples = 1024;
constexpr std::size_t kMostTrials = 256;
constexpr std::array<std::size_t, 10> kHeadCounts = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
constexpr std::size_t kLongestSample = std::size_t{1} << 14;
constexpr std::size_t kLeastTrained = std::size_t{1} << 10;
constexpr std::size_t kMostTrained = std::size_t{1} << 15;
constexpr std::size_t kTableSize = 1024;  // more than the entropy tables of a dictionary ever take

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// Heads end to end, as zdict wants them.
struct Samples {
  Bytes bytes;
  std::vector<std::size_t> sizes;

  void add(std::span<const std::byte> head) {
    bytes.insert(bytes.end(), head.begin(), head.end());
    sizes.push_back(head.size());
  }
};

/// Up to `count` heads at even distances.
std::vector<std::span<const std::byte>> spread(std::span<const Bytes> heads, std::size_t count) {
  count = std::min(count, heads.size());
  std::vector<std::span<const std::byte>> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.emplace_back(heads[(2 * k + 1) * heads.size() / (2 * count)]);
  return chosen;
}

/// The content with entropy tables for the samples; empty where zstd cannot make any of them.
Bytes with_tables(const Bytes& content, const Samples& samples) {
  Bytes made(content.size() + kTableSize);
  ZDICT_params_t parameters{};
  parameters.compressionLevel = kLevel;
  const std::size_t size =
      ZDICT_finalizeDictionary(made.data(), made.size(), content.data(), content.size(), samples.bytes.data(),
                               samples.sizes.data(), static_cast<unsigned>(samples.sizes.size()), parameters);
  made.resize(ZDICT_isError(size) != 0 ? 0 : size);
  return made;
}

Bytes trained(std::size_t most, const Samples& samples) {
  Bytes made(most);
  const std::size_t size = ZDICT_trainFromBuffer(made.data(), made.size(), samples.bytes.data(), samples.sizes.data(),
                                                 static_cast<unsigned>(samples.sizes.size()));
  made.resize(ZDICT_isError(size) != 0 ? 0 : size);
  return made;
}

std::vector<Bytes> candidates(std::span<const Bytes> heads) {
  Samples samples;
  for (const auto head : spread(heads, kMostSamples)) samples.add(head.first(std::min(head.size(), kLongestSample)));
  std::vector<Bytes> made;
  for (const std::size_t count : kHeadCounts) {
    if (count >= heads.size()) break;
    Samples content;
    for (const auto head : spread(heads, count)) content.add(head.first(std::min(head.size(), kLongestSample)));
    made.push_back(content.bytes);
    made.push_back(with_tables(content.bytes, samples));
  }
  for (std::size_t most = kLeastTrained; most <= kMostTrained && most < samples.bytes.size(); most *= 2) {
    made.push_back(trained(most, samples));
  }
  std::erase_if(made, [](const Bytes& dictionary) { return dictionary.empty(); });
  return made;
}

/// Of a bundle with this dictionary, as far as it depends on it, from the heads tried.
double cost(const Bytes& dictionary, std::span<const std::span<const std::byte>> trials, std::size_t head_count) {
  HeadPacker packer(dictionary);
  std::size_t stored = 0;
  for (const auto head : trials) stored += packer.pack(head).size();
  constexpr std::size_t kChecksum = 4;
  return static_cast<double>(stored) * static_cast<double>(head_count) / static_cast<double>(trials.size()) +
         static_cast<double>(dictionary.empty() ? 0 : dictionary.size() + kChecksum);
}

}  // namespace

struct HeadPacker::Context {
  std::unique_ptr<ZSTD_CCtx, FreeContext> zstd{ZSTD_createCCtx()};
};

HeadPacker::HeadPacker(std::span<const std::byte> dictionary) : context_(std::make_unique<Context>()) {
  ZSTD_CCtx* zstd = context_->zstd.get();
  ZSTD_CCtx_setParameter(zstd, ZSTD_c_compressionLevel, kLevel);
  // The index of the bundle says all of that.
  ZSTD_CCtx_setParameter(zstd, ZSTD_c_contentSizeFlag, 0);
  ZSTD_CCtx_setParameter(zstd, ZSTD_c_checksumFlag, 0);
  ZSTD_CCtx_setParameter(zstd, ZSTD_c_dictIDFlag, 0);
  if (!dictionary.empty()) ZSTD_CCtx_loadDictionary(zstd, dictionary.data(), dictionary.size());
}

HeadPacker::~HeadPacker() = default;

std::vector<std::byte> HeadPacker::pack(std::span<const std::byte> head) {
  Bytes frame(ZSTD_compressBound(head.size()));
  const std::size_t size = ZSTD_compress2(context_->zstd.get(), frame.data(), frame.size(), head.data(), head.size());
  const bool made = ZSTD_isError(size) == 0 && size > kFrameMagic.size() &&
                    std::equal(kFrameMagic.begin(), kFrameMagic.end(), frame.begin());
  const std::size_t stored = made ? size - kFrameMagic.size() : head.size();
  if (stored >= head.size() || stored < least_stored_size(head.size())) return {head.begin(), head.end()};
  return {frame.begin() + kFrameMagic.size(), frame.begin() + static_cast<std::ptrdiff_t>(size)};
}

std::optional<std::vector<std::byte>> unpack_head(std::span<const std::byte> frame, std::size_t size,
                                                  std::span<const std::byte> dictionary) {
  Bytes whole(kFrameMagic.begin(), kFrameMagic.end());
  whole.insert(whole.end(), frame.begin(), frame.end());
  // zstd would go on with a second frame.
  if (ZSTD_findFrameCompressedSize(whole.data(), whole.size()) != whole.size()) return {};
  const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  Bytes head(size);
  if (ZSTD_decompress_usingDict(context.get(), head.data(), head.size(), whole.data(), whole.size(), dictionary.data(),
                                dictionary.size()) != size) {
    return {};
  }
  return head;
}

std::vector<std::byte> choose_dictionary(std::span<const std::vector<std::byte>> heads) {
  const auto trials = spread(heads, kMostTrials);
  if (trials.empty()) return {};
  Bytes best;
  double least = cost(best, trials, heads.size());
  for (Bytes& candidate : candidates(heads)) {
    const double bytes = cost(candidate, trials, heads.size());
    if (bytes >= least) continue;
    least = bytes;
    best = std::move(candidate);
  }
  return best;
}

}  // namespace sbrdf::internal
