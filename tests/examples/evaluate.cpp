// Evaluates a material in one direction: evaluate FILE
#include <sbrdf/sbrdf.h>

#include <cstdio>

int main(int argc, char** argv) {
  const auto material = sbrdf::Material::open(argc > 1 ? argv[1] : "kurt:fabric112");
  if (!material) return std::fprintf(stderr, "%s\n", material.error().message.c_str()), 1;

  std::vector<float> f_r(material->channel_count());  // [1/sr], without cosine
  material->evaluate(sbrdf::pair_from_degrees(30, 0, 45, 180), f_r);
  for (const float value : f_r) std::printf("%.6g\n", static_cast<double>(value));
}
