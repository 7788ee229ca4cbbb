#pragma once

#include "codec/file/index.h"
#include "codec/file/recorder.h"

namespace sbrdf::internal {

/// Which channel is predicted first, and how activities are scaled: sets base_channel and activity_shift of an index
/// whose channels and scale are there. Tried on the crossings, or, where there are many other samples, on some of
/// those: first each of three channels, then with the best one the other scales.
void choose_parameters(SampleRecorder& recorder, SlicedIndex& index);

}  // namespace sbrdf::internal
