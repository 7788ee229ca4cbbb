#include "formats/table/hdf5/handle.h"

#include <string_view>

namespace sbrdf::internal {
namespace {

std::recursive_mutex& library() {
  static std::recursive_mutex mutex;
  return mutex;
}

herr_t take_first(unsigned /*depth*/, const H5E_error2_t* error, void* text) {
  auto& first = *static_cast<std::string*>(text);
  if (first.empty() && error->desc != nullptr) first = error->desc;
  return 0;
}

}  // namespace

// At the end of the program the library would close what could not be closed before, such as a file on a full disk, and
// fall over it.
Hdf5Lock::Hdf5Lock() : lock_(library()) {
  static const herr_t never_at_exit = H5dont_atexit();
  static_cast<void>(never_at_exit);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string hdf5_message(const std::string& what) {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &reason);
  H5Eclear2(H5E_DEFAULT);
  for (char& c : reason) {
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  }
  return what + (reason.empty() ? "" : "; the HDF5 library says: " + reason);
}

}  // namespace sbrdf::internal
