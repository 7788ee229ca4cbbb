// Another project, which knows the installed header only: f_r of each file in the directions 30, 0, 45, 180 degrees.
#include <sbrdf/sbrdf.h>

#include <cstdio>

int main(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const auto material = sbrdf::Material::open(argv[k]);
    if (!material) return std::fprintf(stderr, "%s: %s\n", argv[k], material.error().message.c_str()), 1;
    std::vector<float> f_r(material->channel_count());
    material->evaluate(sbrdf::pair_from_degrees(30, 0, 45, 180), f_r);
    for (std::size_t c = 0; c < f_r.size(); ++c) {
      std::printf("%s%.9g", c == 0 ? "" : ",", static_cast<double>(f_r[c]));
    }
    std::printf("\n");
  }
  const auto missing = sbrdf::Material::open("no such file");
  return missing || missing.error().code != sbrdf::ErrorCode::kIo ? 2 : 0;
}
