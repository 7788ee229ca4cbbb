#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "codec/atlas/paper/paper_textures.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

/// Evaluates the paper's textures as its shader would (sections 7 and 8): four look-ups in each of the first three and
/// eight in the last, each of which the filter makes bilinear, and the sum max(p + q + s + t - 3 c, min). `min` is the
/// least of the slices read, after the filter: higher than that of all 32 slices, so it stands for the sum more often
/// than in the Evaluator. There is no bound from above, which the Evaluator has in the log domain: the greatest after
/// the filter is so low that it takes off more than it mends. Axial and diagonal slices wrap in the direction of their
/// 360 rows. Immutable; no allocation.
///
/// **Elevation 0** has no areas, and no horizontal slices of its own. What the textures do hold of it are the rows
/// theta_v = 0 of the other horizontal slices: the values on its ring at the nodes of the azimuths, which by
/// reciprocity are also those at theta_i = 0 and theta_v = an elevation. So for theta_i below the first elevation the
/// near side of the cell has these: as crossings and for three kinds of slices straight lines between them, and for
/// axial slices straight lines along the ring, over s - u, so that an azimuth that means nothing at the pole does not
/// matter there. Vertical slices are whole. What this leaves out are the slices along theta_v and along the azimuth at
/// theta_i = 0: a highlight at normal incidence becomes as wide as the first elevation, which is most of what these
/// textures are off their slices.
class PaperEvaluator {
 public:
  /// `textures` must outlive this.
  explicit PaperEvaluator(const PaperTextures& textures);

  /// f_r [1/sr] of one pair, RGB; 0 where a direction lies below the horizon or an angle is no number. Exchanging i and
  /// v gives the same bits.
  void evaluate(const DirectionPair& pair, std::span<float, 3> values) const;
  /// At frame coordinates [degrees], s in [0, 720], u in [0, 360], theta_i <= theta_v (see FrameGeometry::coordinates).
  void evaluate_at(const Coordinates& x, std::span<float, 3> values) const;

 private:
  using Rgb = std::array<float, 3>;
  struct Azimuths {
    double s = 0, u = 0;  ///< in [0, 720), [0, 360)
  };
  /// Between which elevations an angle lies: `node` and the next one, 0 being the normal.
  struct Place {
    std::size_t node = 0;
    double angle_deg = 0;  ///< brought among the elevations
    float fraction = 0;
  };
  /// The parts of the sum, and the least of the slices read.
  struct Sum {
    Rgb c{}, slices{}, least{};
  };

  [[nodiscard]] static Azimuths exchanged(Azimuths a);
  [[nodiscard]] Place place(double theta_deg) const;
  [[nodiscard]] Rgb read(PaperTextureKind kind, double x, double y) const;
  [[nodiscard]] Rgb crossing(std::size_t v, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb axial(std::size_t v, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb diagonal(std::size_t v, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb horizontal(std::size_t i, double theta_v_deg, Azimuths a) const;
  [[nodiscard]] Rgb at_pole(std::size_t v, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb on_ring(std::size_t v, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb along_view(const Place& view, std::size_t i, Azimuths a) const;
  [[nodiscard]] Rgb along_light(std::size_t v, const Place& light, Azimuths a) const;
  static void add(const Rgb& slice, float weight, Sum& sum);

  const PaperTextures& textures_;
};

}  // namespace sbrdf::internal
