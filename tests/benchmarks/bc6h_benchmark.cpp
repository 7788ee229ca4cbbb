// Speed and quality of the BC6H encoder, beside a search that takes its time.
//
// usage: bc6h_benchmark [BLOCKS] [STEPS]
//   BLOCKS  of each kind (default 200)
//   STEPS   of the long search for each mode and partition (default 0: without it)

#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "formats/core/half.h"
#include "formats/core/parallel.h"
#include "tests/benchmarks/timing.h"
#include "tests/formats/bc6h/drawn_blocks.h"
#include "tests/formats/bc6h/long_search.h"

namespace sbrdf::internal {
namespace {

// Of the peak of 1 octave (1024) for logarithms, of 1 for numbers [dB]; a block without any error counts as 0.01.
double psnr(double error, Bc6hMetric metric) {
  const double peak = metric == Bc6hMetric::kLog ? 1024 : 1;
  const double least = metric == Bc6hMetric::kLog ? 1e-2 : 1e-8;
  return 10 * std::log10(peak * peak / std::max(error / 48, least));
}

struct Judged {
  double psnr = 0;     // mean
  double seconds = 0;  // of the processor
};

Judged encode_all(const std::vector<Bc6hTexels>& blocks, const Bc6hOptions& options) {
  std::vector<Bc6hBytes> encoded;
  const double start = processor_seconds();
  for (const Bc6hTexels& texels : blocks) encoded.push_back(encode_bc6h_block(texels, options));
  Judged judged{.seconds = processor_seconds() - start};
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const Bc6hTexels decoded = decode_bc6h_block(encoded[k], options.is_signed);
    judged.psnr +=
        psnr(bc6h_error(blocks[k], decoded, options.metric), options.metric) / static_cast<double>(blocks.size());
  }
  return judged;
}

// Mean PSNR of the search alone, and of the better one of it and what is found from the encoder's block on.
std::array<double, 2> search_all(const std::vector<Bc6hTexels>& blocks, const Bc6hOptions& options, int steps) {
  std::vector<std::array<double, 2>> found(blocks.size());
  for_all(blocks.size(), 1, [&](std::size_t k) {
    LongBc6hSearch search(blocks[k], options.is_signed, options.metric, static_cast<std::uint32_t>(k));
    const double alone = search.run(3, steps, 12, 20 * steps);
    const double further = search.run_from(encode_bc6h_block(blocks[k], options), 100 * steps);
    found[k] = {psnr(alone, options.metric), psnr(std::min(alone, further), options.metric)};
  });
  std::array<double, 2> mean{};
  for (const auto& one : found) {
    for (std::size_t k = 0; k < 2; ++k) mean[k] += one[k] / static_cast<double>(blocks.size());
  }
  return mean;
}

void run(std::size_t count, int steps) {
  for (const Bc6hMetric metric : {Bc6hMetric::kLog, Bc6hMetric::kLinear}) {
    for (const std::string_view kind : kBc6hBlockKinds) {
      std::mt19937 draw(7);
      std::vector<Bc6hTexels> blocks;
      for (std::size_t k = 0; k < count; ++k) blocks.push_back(draw_bc6h_block(kind, draw));
      Bc6hOptions options{.is_signed = kind == "signed", .metric = metric};
      const auto megabytes = static_cast<double>(count * sizeof(Bc6hTexels)) * 1e-6;
      std::cout << (metric == Bc6hMetric::kLog ? "log " : "linear ") << kind << ':';
      for (const Bc6hSpeed speed : {Bc6hSpeed::kFast, Bc6hSpeed::kThorough}) {
        options.speed = speed;
        const Judged judged = encode_all(blocks, options);
        std::cout << (speed == Bc6hSpeed::kFast ? "  fast " : "  thorough ") << judged.psnr << " dB, "
                  << megabytes / judged.seconds << " MB/s";
      }
      if (steps > 0) {
        const auto [alone, best] = search_all(blocks, options, steps);
        std::cout << "  long search " << alone << " dB, best of all " << best << " dB";
      }
      std::cout << std::endl;
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal

int main(int count, char** arguments) {
  sbrdf::internal::run(count > 1 ? std::strtoul(arguments[1], nullptr, 10) : 200,
                       count > 2 ? std::atoi(arguments[2]) : 0);
  return 0;
}
