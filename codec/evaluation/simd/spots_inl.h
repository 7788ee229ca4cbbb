// From pairs of vectors to frame coordinates as whole numbers. Compiled once for each set of instructions: included by
// kernel.cpp alone, for each anew.
#if defined(SBRDF_SPOTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SBRDF_SPOTS_INL_H
#undef SBRDF_SPOTS_INL_H
#else
#define SBRDF_SPOTS_INL_H
#endif

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "codec/evaluation/tables/slice_tables.h"
#include "formats/core/directions.h"

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kBlock = 8;  // pairs that are worked out together

/// Where points lie in the frame: the turns of their four coordinates, none beyond the last of its axis, and of the
/// angle of a guide.
struct Spots {
  alignas(64) std::array<std::array<std::uint32_t, kAxisCount>, kBlock> x;
  alignas(64) std::array<std::uint32_t, kBlock> guide;
};

/// Coordinates of the pairs of a block, one array for each; those beyond the last pair mean nothing.
using Column = std::array<double, kBlock>;
struct Vectors {
  alignas(64) std::array<Column, 3> i;
  alignas(64) std::array<Column, 3> v;
};

/// Takes directions; another one stands in the place of what is none, or is below the horizon. Which ones are above.
template <class D>
HWY_INLINE hn::Mask<D> take_directions(D d, hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z, std::size_t k,
                                       std::array<Column, 3>& into) {
  const hn::Rebind<double, D> wide;
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, 1.0F);
  const auto finite = hn::And(hn::And(hn::IsFinite(x), hn::IsFinite(y)), hn::IsFinite(z));
  const auto some = hn::Or(hn::Or(hn::Ne(x, zero), hn::Ne(y, zero)), hn::Ne(z, zero));
  const auto usable = hn::And(hn::And(finite, some), hn::Ge(z, zero));
  hn::Store(hn::PromoteTo(wide, hn::IfThenElse(usable, x, one)), wide, into[0].data() + k);
  hn::Store(hn::PromoteTo(wide, hn::IfThenElse(usable, y, one)), wide, into[1].data() + k);
  hn::Store(hn::PromoteTo(wide, hn::IfThenElse(usable, z, one)), wide, into[2].data() + k);
  return usable;
}

/// Takes a block of pairs, of which `size` are given. Bits say of which both directions are above the horizon.
HWY_INLINE unsigned take(const float* w_i, const float* w_v, std::size_t size, Vectors& pairs) {
  const hn::Rebind<float, hn::CappedTag<double, kBlock>> d;
  std::array<std::array<float, 3 * kBlock>, 2> padded;
  if (size < kBlock) {
    for (std::size_t k = 0; k < 3 * kBlock; ++k) {
      padded[0][k] = k < 3 * size ? w_i[k] : 1.0F;
      padded[1][k] = k < 3 * size ? w_v[k] : 1.0F;
    }
    w_i = padded[0].data();
    w_v = padded[1].data();
  }
  unsigned above = 0;
  for (std::size_t k = 0; k < kBlock; k += hn::Lanes(d)) {
    hn::Vec<decltype(d)> x, y, z;
    hn::LoadInterleaved3(d, w_i + 3 * k, x, y, z);
    const auto i_above = take_directions(d, x, y, z, k, pairs.i);
    hn::LoadInterleaved3(d, w_v + 3 * k, x, y, z);
    const auto both = hn::And(i_above, take_directions(d, x, y, z, k, pairs.v));
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, both, bits.data());
    above |= static_cast<unsigned>(bits[0]) << k;
  }
  return above & ((1U << size) - 1);
}

/// Takes a single pair.
HWY_INLINE unsigned take_first(const float* w_i, const float* w_v, Vectors& pairs) {
  const hn::FixedTag<float, 1> d;
  const auto all = [&](const float* w, std::array<Column, 3>& into) HWY_ATTR {
    return take_directions(d, hn::Set(d, w[0]), hn::Set(d, w[1]), hn::Set(d, w[2]), 0, into);
  };
  return hn::AllTrue(d, hn::And(all(w_i, pairs.i), all(w_v, pairs.v))) ? 1 : 0;
}

template <class D>
using Turns = hn::Vec<hn::Rebind<std::int32_t, D>>;

/// atan2 [degrees] in [-180, 180]; 0 where both are 0.
template <class D>
HWY_INLINE hn::Vec<D> atan2_degrees(D d, hn::Vec<D> y, hn::Vec<D> x) {
  const auto zero = hn::Zero(d);
  const auto ratio = hn::Div(hn::Abs(y), hn::Abs(x));  // infinite: 90 degrees
  auto angle = hn::Mul(hn::Atan(d, ratio), hn::Set(d, 180 / kPi));
  angle = hn::IfThenElse(hn::Eq(y, zero), zero, angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(hn::Set(d, 180), angle), angle);
  return hn::CopySign(angle, y);
}

template <class D>
HWY_INLINE Turns<D> turns_of(D /*d*/, hn::Vec<D> degrees, hn::Vec<D> scale, hn::Vec<D> bias, Turns<D> flip) {
  const hn::Rebind<std::int32_t, D> di;
  return hn::Xor(hn::DemoteTo(di, hn::Round(hn::MulAdd(degrees, scale, bias))), flip);
}
template <class D>
HWY_INLINE Turns<D> turns_of(D d, hn::Vec<D> degrees, const TurnRule& rule) {
  const hn::Rebind<std::int32_t, D> di;
  return turns_of(d, degrees, hn::Set(d, rule.scale), hn::Set(d, rule.bias), hn::Set(di, rule.flip));
}

template <class D>
HWY_INLINE hn::Vec<D> length_of(hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z) {
  return hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))));
}

/// Arguments of atan2 that give the four angles of a frame, and a guide's.
template <class D>
struct Arguments {
  std::array<hn::Vec<D>, kAxisCount + 1> y;
  std::array<hn::Vec<D>, kAxisCount + 1> x;
};

/// Half and difference angles, in the order of the frame: phi_h, phi_d, theta_d, theta_h. With h = i + v and e = i - v,
/// theta_d is between their lengths, and e turned by -phi_h about z and by -theta_h about y points to (phi_d, 90). All
/// times lengths, which do not matter. Exchanging i and v negates e, which phi_d does not see.
template <class D>
HWY_INLINE void half_difference_arguments(D d, const Vectors& pairs, std::size_t k, double guide_ratio,
                                          Arguments<D>& angles) {
  const auto one = hn::Set(d, 1.0);
  std::array<hn::Vec<D>, 3> i;
  std::array<hn::Vec<D>, 3> v;
  for (std::size_t c = 0; c < 3; ++c) {
    i[c] = hn::Load(d, pairs.i[c].data() + k);
    v[c] = hn::Load(d, pairs.v[c].data() + k);
  }
  const auto i_scale = hn::Div(one, length_of<D>(i[0], i[1], i[2]));
  const auto v_scale = hn::Div(one, length_of<D>(v[0], v[1], v[2]));
  std::array<hn::Vec<D>, 3> h;
  std::array<hn::Vec<D>, 3> e;
  for (std::size_t c = 0; c < 3; ++c) {
    i[c] = hn::Mul(i[c], i_scale);
    v[c] = hn::Mul(v[c], v_scale);
    h[c] = hn::Add(i[c], v[c]);
    e[c] = hn::Sub(i[c], v[c]);
  }
  const auto h_flat2 = hn::Add(hn::Mul(h[0], h[0]), hn::Mul(h[1], h[1]));
  const auto h_flat = hn::Sqrt(h_flat2);
  const auto h_length = hn::Sqrt(hn::Add(h_flat2, hn::Mul(h[2], h[2])));
  // A half vector on the normal has the azimuth 0.
  const auto on_normal = hn::Eq(h_flat2, hn::Zero(d));
  const auto h_x = hn::IfThenElse(on_normal, one, h[0]);
  const auto along = hn::Add(hn::Mul(e[0], h_x), hn::Mul(e[1], h[1]));
  auto across = hn::Mul(hn::Sub(hn::Mul(e[1], h_x), hn::Mul(e[0], h[1])), h_length);
  auto ahead = hn::Sub(hn::Mul(along, h[2]), hn::Mul(e[2], h_flat2));
  // One of the two directions of e, always the same one.
  const auto zero = hn::Zero(d);
  const auto turn = hn::Or(hn::Lt(across, zero), hn::And(hn::Eq(across, zero), hn::Lt(ahead, zero)));
  across = hn::IfThenElse(turn, hn::Neg(across), across);
  ahead = hn::IfThenElse(turn, hn::Neg(ahead), ahead);
  angles.y = {h[1], across, length_of<D>(e[0], e[1], e[2]), h_flat, h_flat};
  angles.x = {h_x, ahead, h_length, h[2], h[2]};
  if (guide_ratio == 1) return;
  const auto x = hn::Mul(h[0], hn::Set(d, std::min(1.0, guide_ratio)));
  const auto y = hn::Mul(h[1], hn::Set(d, 1 / std::max(1.0, guide_ratio)));
  angles.y[kAxisCount] = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
}

/// phi_i, phi_v, theta_v, theta_i: turned into the coordinates of the frame by elevation_spots.
template <class D>
HWY_INLINE void elevation_arguments(D d, const Vectors& pairs, std::size_t k, Arguments<D>& angles) {
  for (std::size_t side = 0; side < 2; ++side) {
    const std::array<Column, 3>& w = side == 0 ? pairs.i : pairs.v;
    const auto x = hn::Load(d, w[0].data() + k);
    const auto y = hn::Load(d, w[1].data() + k);
    angles.y[side] = y;
    angles.x[side] = x;
    angles.y[kAxisCount - 1 - side] = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
    angles.x[kAxisCount - 1 - side] = hn::Load(d, w[2].data() + k);
  }
}

/// The coordinates of the elevation frame, as FrameGeometry::coordinates has them. `x` are turns of phi_i, phi_v,
/// theta_v and theta_i, each 720 degrees a period or 90; lower and higher are the thetas that decide the order of the
/// pair.
template <class DI>
HWY_INLINE void order_elevation(DI di, std::array<hn::Vec<DI>, kAxisCount>& x) {
  const auto zero = hn::Zero(di);
  const auto s = hn::Add(x[0], x[1]);
  auto u = hn::Sub(x[0], x[1]);
  const auto first = hn::ShiftRight<1>(hn::BitCast(hn::RebindToUnsigned<DI>(), x[kVertical]));
  const auto second = hn::ShiftRight<1>(hn::BitCast(hn::RebindToUnsigned<DI>(), x[kHorizontal]));
  const auto theta_i = hn::BitCast(di, first);
  const auto theta_v = hn::BitCast(di, second);
  u = hn::IfThenElse(hn::Gt(theta_i, theta_v), hn::Neg(u), u);
  u = hn::IfThenElse(hn::Eq(theta_i, theta_v), hn::Abs(u), u);
  const auto lower = hn::Min(theta_i, theta_v);
  const auto upper = hn::Max(theta_i, theta_v);
  // At the pole only phi_v = (s - u) / 2 matters; u = 0 is where its ring was measured.
  const auto on_pole = hn::Eq(lower, zero);
  auto sum = hn::IfThenElse(on_pole, hn::Sub(s, u), s);
  u = hn::IfThenElse(on_pole, zero, u);
  // (s, u) and (s + 360, u + 360) are the same.
  const auto half_turn = hn::Set(di, std::numeric_limits<std::int32_t>::min());
  sum = hn::Xor(sum, hn::And(u, half_turn));
  x = {sum, hn::AndNot(half_turn, u), hn::Add(upper, upper), hn::Add(lower, lower)};
}

template <class D>
HWY_INLINE void find_arguments(D d, const SliceTables& tables, const Vectors& pairs, std::size_t k,
                               Arguments<D>& angles) {
  if (tables.lattice->frame == FrameId::kHalfDifference) {
    half_difference_arguments(d, pairs, k, tables.guide_ratio, angles);
  } else {
    elevation_arguments(d, pairs, k, angles);
  }
}

/// The angle of a guide that is not as wide both ways; other guides ask for theta_h.
template <class D>
HWY_INLINE Turns<D> guide_turns(D d, const Arguments<D>& angles) {
  return turns_of(d, atan2_degrees(d, angles.y[kAxisCount], angles.x[kAxisCount]),
                  turn_rule(FrameId::kHalfDifference, kVertical));
}

/// Of a whole block.
HWY_INLINE void find_spots(const SliceTables& tables, const Vectors& pairs, Spots& spots) {
  using D = hn::CappedTag<double, kBlock>;
  const D d;
  const hn::Rebind<std::int32_t, D> di;
  const hn::Rebind<std::uint32_t, D> du;
  const LatticeTables& lattice = *tables.lattice;
  const bool half_difference = lattice.frame == FrameId::kHalfDifference;
  for (std::size_t k = 0; k < kBlock; k += hn::Lanes(d)) {
    Arguments<D> angles;
    find_arguments(d, tables, pairs, k, angles);
    std::array<Turns<D>, kAxisCount> x;
    for (std::size_t a = 0; a < kAxisCount; ++a) {
      if (a == kAxial && half_difference && lattice.axial_stays) {
        x[a] = hn::Zero(di);
      } else {
        x[a] = turns_of(d, atan2_degrees(d, angles.y[a], angles.x[a]), turn_rule(lattice.frame, a));
      }
    }
    if (!half_difference) order_elevation(di, x);
    hn::Store(hn::BitCast(du, tables.guide_ratio == 1 ? x[kVertical] : guide_turns(d, angles)), du,
              spots.guide.data() + k);
    std::array<hn::Vec<hn::Rebind<std::uint32_t, D>>, kAxisCount> held;
    for (std::size_t a = 0; a < kAxisCount; ++a) {
      held[a] = hn::Min(hn::BitCast(du, x[a]), hn::Set(du, lattice.last_turn[a]));
    }
    hn::StoreInterleaved4(held[0], held[1], held[2], held[3], du, spots.x[k].data());
  }
}

// Numbers that are each in a vector of their own as one vector, without a detour through memory.
template <class T, std::size_t N, std::size_t kCount>
HWY_INLINE hn::Vec<hn::FixedTag<T, N>> together(const std::array<hn::Vec<hn::FixedTag<T, 1>>, kCount>& each,
                                                std::size_t first) {
  if constexpr (N == 1) {
    return each[first];
  } else {
    return hn::Combine(hn::FixedTag<T, N>(), together<T, N / 2>(each, first + N / 2), together<T, N / 2>(each, first));
  }
}

// The turns of four angles, N at once.
template <std::size_t N>
HWY_INLINE void four_turns(const LatticeTables& lattice, const Arguments<hn::FixedTag<double, 1>>& angles,
                           std::int32_t* turns) {
  const hn::FixedTag<double, N> d;
  const hn::FixedTag<std::int32_t, N> di;
  for (std::size_t k = 0; k < kAxisCount; k += N) {
    const auto degrees = atan2_degrees(d, together<double, N>(angles.y, k), together<double, N>(angles.x, k));
    hn::Store(turns_of(d, degrees, hn::Load(d, lattice.turn_scale.data() + k),
                       hn::Load(d, lattice.turn_bias.data() + k), hn::Load(di, lattice.turn_flip.data() + k)),
              di, turns + k);
  }
}

/// Of the first pair of a block: the same to the last bit, by fewer steps.
HWY_INLINE void find_first_spot(const SliceTables& tables, const Vectors& pairs, Spots& spots) {
  using D = hn::FixedTag<double, 1>;
  using DI = hn::FixedTag<std::int32_t, 1>;
  const hn::FixedTag<std::uint32_t, kAxisCount> d4;
  const LatticeTables& lattice = *tables.lattice;
  Arguments<D> angles;
  find_arguments(D(), tables, pairs, 0, angles);
  alignas(16) std::array<std::int32_t, kAxisCount> each;
  four_turns<std::min<std::size_t>(kAxisCount, HWY_MAX_BYTES / sizeof(double))>(lattice, angles, each.data());
  const std::int32_t guide = tables.guide_ratio == 1 ? each[kVertical] : hn::GetLane(guide_turns(D(), angles));
  spots.guide[0] = static_cast<std::uint32_t>(guide);
  const hn::FixedTag<std::int32_t, kAxisCount> di4;
  auto turns = hn::Load(di4, each.data());
  if (lattice.frame == FrameId::kElevation) {
    std::array<hn::Vec<DI>, kAxisCount> x;
    for (std::size_t a = 0; a < kAxisCount; ++a) x[a] = hn::Set(DI(), each[a]);
    order_elevation(DI(), x);
    turns = together<std::int32_t, kAxisCount>(x, 0);
  }
  hn::Store(hn::Min(hn::BitCast(d4, turns), hn::Load(d4, lattice.last_turn.data())), d4, spots.x[0].data());
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
