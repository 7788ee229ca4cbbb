#pragma once

#include "formats/core/result.h"

namespace sbrdf::internal {

/// What every piece of work returns that was asked to stop: by a signal, or by whoever watches its progress.
[[nodiscard]] inline Error interrupted_error() { return io_error("interrupted"); }

}  // namespace sbrdf::internal
