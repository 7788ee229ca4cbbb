#include "formats/os/descriptor.h"

#include <cerrno>
#include <system_error>

#include "formats/core/interrupted.h"

namespace sbrdf::internal {

Error system_error(const std::string& what) {
  if (errno == EINTR) return interrupted_error();
  return io_error(what + ": " + std::generic_category().message(errno));
}

}  // namespace sbrdf::internal
