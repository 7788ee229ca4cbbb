// Converts a material and tells what was lost on the way: convert IN OUT [SAMPLES]
#include <sbrdf/sbrdf.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc < 3) return 1;
  const auto material = sbrdf::Material::open(argv[1]);
  if (!material) return std::fprintf(stderr, "%s: %s\n", argv[1], material.error().message.c_str()), 2;
  for (const sbrdf::Finding& finding : material->traits().findings) {
    std::printf("%llu %s\n", static_cast<unsigned long long>(finding.count), finding.what.c_str());
  }

  sbrdf::SaveOptions options;
  if (argc > 3) options.format["samples"] = argv[3];  // the options of `sbrdf convert`, without the dashes
  options.progress = [](double fraction) { return fraction <= 1; };  // false would stop it
  const auto report = material->save(argv[2], options);
  if (!report) return std::fprintf(stderr, "%s: %s\n", argv[2], report.error().message.c_str()), 3;

  std::printf("%llu bytes\n", static_cast<unsigned long long>(report->bytes));
  for (const sbrdf::Remark& remark : report->remarks) std::printf("%s\n", remark.text.c_str());
}
