// Runs a fuzz target without libFuzzer: on its seeds, and on so many damaged copies of them, the same ones each time.
// usage: NAME_replay FOLDER_OF_SEEDS COPIES FINDING
// An input that ends the program is left in the file FINDING.

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string_view>
#include <vector>

#include <sanitizer/common_interface_defs.h>

#include "tests/fuzz/require.h"

// Not every target has one.
extern "C" [[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size,
                                                             std::size_t max_size, unsigned seed);

namespace {

using Input = std::vector<std::uint8_t>;

std::minstd_rand random_numbers;  // NOLINT(cert-msc51-cpp): the same at each run
const Input* current = nullptr;
const char* finding = nullptr;

void leave_finding() {
  if (current == nullptr) return;
  if (std::FILE* const file = std::fopen(finding, "wb")) {
    std::fwrite(current->data(), 1, current->size(), file);
    std::fclose(file);
    std::fprintf(stderr, "the input is in %s\n", finding);
  }
}

std::size_t below(std::size_t end) { return random_numbers() % end; }

/// One byte, another length, or some bytes over others; the length stays within `most`.
void damage(Input& input, std::size_t most) {
  static constexpr std::array<std::uint8_t, 7> kHarsh = {0, 1, 0x7f, 0x80, 0xff, '-', '9'};
  if (input.empty()) input.push_back(0);
  const std::size_t at = below(input.size());
  const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
  const auto end = place + static_cast<std::ptrdiff_t>(below(std::min<std::size_t>(input.size() - at, 64)) + 1);
  switch (below(6)) {
    case 0:
      *place = static_cast<std::uint8_t>(*place ^ (1U << below(8)));
      break;
    case 1:
      *place = kHarsh[below(kHarsh.size())];
      break;
    case 2:
      std::fill(place, end, kHarsh[below(kHarsh.size())]);
      break;
    case 3:
      input.erase(place, end);
      break;
    case 4:
      input.resize(at);
      break;
    default: {
      const Input piece(place, end);
      const std::size_t to = below(input.size() + 1);
      if (input.size() + piece.size() <= most) {
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(to), piece.begin(), piece.end());
      }
    }
  }
}

Input damaged(const Input& seed) {
  const std::size_t most = std::max<std::size_t>(4096, 2 * seed.size());
  Input input = seed;
  if (LLVMFuzzerCustomMutator == nullptr) {
    for (std::size_t k = 0; k <= below(4); ++k) damage(input, most);
    return input;
  }
  input.resize(most);
  input.resize(LLVMFuzzerCustomMutator(input.data(), seed.size(), most, static_cast<unsigned>(random_numbers())));
  return input;
}

void run(const Input& input) {
  current = &input;
  LLVMFuzzerTestOneInput(input.data(), input.size());
  current = nullptr;
}

std::vector<Input> seeds_in(const char* folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) paths.push_back(entry.path());
  std::ranges::sort(paths);  // a folder has no order
  std::vector<Input> seeds;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return seeds;
}

}  // namespace

// What libFuzzer offers to a mutator.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t max_size) {
  Input input(bytes, bytes + size);
  damage(input, max_size);
  std::ranges::copy(input, bytes);
  return input.size();
}

int main(int argc, char** argv) {
  const std::string_view number = argc == 4 ? argv[2] : "";
  std::size_t copies = 0;
  if (std::from_chars(number.data(), number.data() + number.size(), copies).ec != std::errc()) {
    std::fprintf(stderr, "usage: %s FOLDER_OF_SEEDS COPIES FINDING\n", argv[0]);
    return 2;
  }
  finding = argv[3];
  __sanitizer_set_death_callback(leave_finding);
  std::signal(SIGABRT, [](int) {
    leave_finding();
    std::_Exit(1);
  });
  const std::vector<Input> seeds = seeds_in(argv[1]);
  if (seeds.empty()) {
    std::fprintf(stderr, "%s: no seeds\n", argv[1]);
    return 2;
  }
  for (const Input& seed : seeds) run(seed);
  for (std::size_t k = 0; k < copies; ++k) run(damaged(seeds[k % seeds.size()]));
  std::printf("%zu seeds and %zu damaged copies\n", seeds.size(), copies);
  return 0;
}
