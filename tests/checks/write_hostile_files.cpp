// Writes files that are valid and small, and that a careless reader would need gigabytes for.
//   write_hostile_files FOLDER
#include <cstdio>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "tests/support/hostile_files.h"

namespace {

using namespace sbrdf::internal;

void write(const std::string& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  std::printf("%10zu bytes  %s\n", bytes.size(), path.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  const std::string folder = std::string(argv[1]) + "/";
  for (const HostileCase& hostile : hostile_cases()) write(folder + hostile.name, hostile.bytes);
  return 0;
}
