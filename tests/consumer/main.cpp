// Uses something of each installed layer, so that each archive and all that it links must be found.
#include <array>

#include "codec/frame/frame.h"
#include "converters/files/format_table.h"
#include "converters/models/kurt.h"
#include "formats/core/directions.h"

int main() {
  const auto model = sbrdf::internal::kurt_material("fabric112");
  if (!model.ok() || !sbrdf::internal::elevation_frame(14, 36, {}).ok()) return 1;

  const auto source = sbrdf::internal::make_kurt_source(*model);
  const std::array pairs = {sbrdf::internal::DirectionPair{{0.5, 0}, {0.7, 1}}};
  std::array<float, 3> values{};
  source->evaluate(pairs, values);

  const bool refuses_nothing = !sbrdf::find_writer("").ok();
  return values[0] > 0 && refuses_nothing ? 0 : 2;
}
