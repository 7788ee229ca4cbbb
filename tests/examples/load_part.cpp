// Loads what one pair of directions needs, a range of bytes at a time, as over a network: load_part FILE.sbrdf
#include <sbrdf/sbrdf.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <mutex>

int main(int argc, char** argv) {
  if (argc < 2) return 1;
  std::ifstream file(argv[1], std::ios::binary | std::ios::ate);
  if (!file) return std::fprintf(stderr, "%s: cannot be opened\n", argv[1]), 2;
  const auto size = static_cast<std::uint64_t>(file.tellg());

  std::mutex one_at_a_time;
  std::uint64_t bytes_read = 0;
  const auto read = [&](std::uint64_t offset, std::span<std::byte> target) -> std::optional<sbrdf::Error> {
    const std::scoped_lock lock(one_at_a_time);
    file.seekg(static_cast<std::streamoff>(offset));
    if (!file.read(reinterpret_cast<char*>(target.data()), static_cast<std::streamsize>(target.size()))) {
      return sbrdf::Error{sbrdf::ErrorCode::kIo, "cannot be read", offset};
    }
    bytes_read += target.size();
    return std::nullopt;
  };

  const sbrdf::DirectionPair pair = sbrdf::pair_from_degrees(30, 0, 45, 180);
  sbrdf::OpenOptions options;
  options.part = sbrdf::Part{.pairs = {pair}};
  const auto material = sbrdf::Material::open(size, read, options);
  if (!material) return std::fprintf(stderr, "%s: %s\n", argv[1], material.error().message.c_str()), 3;

  std::vector<float> f_r(material->channel_count());
  material->evaluate(pair, f_r);
  for (const float value : f_r) std::printf("%.6g\n", static_cast<double>(value));
  std::printf("%llu of %llu bytes read\n", static_cast<unsigned long long>(bytes_read),
              static_cast<unsigned long long>(size));
}
