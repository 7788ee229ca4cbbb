#pragma once

#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

#include "formats/core/result.h"

namespace sbrdf::internal {

// The library is not safe for threads as Debian builds it, so every call to it is made while an Hdf5Lock lives.

/// Locks the library; also keeps it from printing what went wrong. May be taken again by the thread that holds it.
class Hdf5Lock {
 public:
  Hdf5Lock();

 private:
  std::scoped_lock<std::recursive_mutex> lock_;
};

/// An identifier of the library, closed with its own function. Invalid where the library failed.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() {
    if (!ok()) return;
    const Hdf5Lock lock;
    close_(id_);
  }

  [[nodiscard]] bool ok() const { return id_ >= 0; }
  [[nodiscard]] hid_t id() const { return id_; }
  /// Closes it now; false where the library failed, such as for a full disk.
  [[nodiscard]] bool close() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// "HDF5: " and the innermost of what the library last complained about; `what` where it says nothing.
[[nodiscard]] std::string hdf5_message(const std::string& what);

}  // namespace sbrdf::internal
