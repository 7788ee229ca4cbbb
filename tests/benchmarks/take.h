#pragma once

#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Ends a program that is run by hand.
[[noreturn]] inline void fail(const std::string& message) {
  std::cerr << message << '\n';
  std::exit(EXIT_FAILURE);
}

/// The value, or the end of the program with the message.
template <class T>
T take(Result<T> result) {
  if (!result) fail(result.error().message);
  return *std::move(result);
}

}  // namespace sbrdf::internal
