// The share of the light from 60 degrees that a material sends back, as a renderer would work it out: sample FILE
#include <sbrdf/sbrdf.h>

#include <cmath>
#include <cstdio>

int main(int argc, char** argv) {
  const auto material = sbrdf::Material::open(argc > 1 ? argv[1] : "kurt:fabric112");
  if (!material) return std::fprintf(stderr, "%s\n", material.error().message.c_str()), 1;

  constexpr int kCount = 10000;
  const std::array<float, 3> w_i = {0.8660254F, 0, 0.5F};
  std::vector<float> f_r(material->channel_count());  // [1/sr], without cosine
  std::vector<double> share(f_r.size());
  for (int k = 0; k < kCount; ++k) {
    const std::array<float, 2> u = {(static_cast<float>(k) + 0.5F) / kCount,
                                    static_cast<float>(std::fmod(0.6180339887498949 * k, 1))};
    const sbrdf::Sample drawn = material->sample(w_i, u, f_r);
    if (drawn.pdf == 0) continue;
    for (std::size_t c = 0; c < f_r.size(); ++c) share[c] += f_r[c] * drawn.w_v[2] / drawn.pdf / kCount;
  }
  for (const double value : share) std::printf("%.4f\n", value);
}
