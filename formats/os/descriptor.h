#pragma once

#include <unistd.h>

#include <string>
#include <utility>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// An open file of the operating system, closed with this. A negative number is none: see open(2).
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// kIo: `what` and the reason that errno gives. A call that a signal cut short is the interrupt, not an error of its
/// own.
[[nodiscard]] Error system_error(const std::string& what);

}  // namespace sbrdf::internal
