#include "codec/series/coefficient_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "codec/entropy/range_coder.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kClasses = 6;
constexpr std::uint32_t kMostUnary = 15;  // steps of a size that are decided one by one
constexpr std::size_t kStepContexts = 7;
constexpr unsigned kMostExtraBits = 23;

/// What is expected of a coefficient: by field (the first one or a colour) and class.
struct Contexts {
  Contexts() {
    // Of 32 parts each: most coefficients without neighbours are 0, most others are not.
    constexpr std::array<DecisionCounts, kClasses> kStart = {
        {{38, 3}, {26, 10}, {19, 13}, {16, 16}, {10, 22}, {6, 26}}};
    for (auto& field : zero) std::copy(kStart.begin(), kStart.end(), field.begin());
  }

  std::array<std::array<DecisionCounts, kClasses>, 2> zero{};  ///< yes: it is not 0
  std::array<std::array<DecisionCounts, kStepContexts>, (kClasses + 1) / 2> larger{};
};

/// The sizes of the coefficients known so far.
class Neighbours {
 public:
  Neighbours(const SeriesBasis& basis, std::span<const std::int32_t> field, std::span<const std::int32_t> first)
      : basis_(basis), field_(field), first_(first) {}

  [[nodiscard]] std::size_t class_of(std::uint32_t n) const {
    const SeriesTerm& t = basis_.terms[n];
    const std::uint32_t lower = basis_.harmonics[t.harmonic].lower;
    std::uint32_t near = 2 * (at(t.harmonic, t.b, t.a, 0, 1) + at(t.harmonic, t.b, t.a, 1, 0)) +
                         at(t.harmonic, t.b, t.a, 0, 2) + at(t.harmonic, t.b, t.a, 2, 0) +
                         at(t.harmonic, t.b, t.a, 1, 1);
    if (lower != Harmonic::kNone) near += 2 * at(lower, t.b, t.a, 0, 0);
    if (!first_.empty()) near += 2 * std::min(size_of(first_[n]), 2U);
    if (near == 0) return 0;
    return std::min<std::size_t>(kClasses - 1, std::max(1, static_cast<int>(std::bit_width(near - 1))));
  }

 private:
  static std::uint32_t size_of(std::int32_t q) { return static_cast<std::uint32_t>(std::abs(q)); }

  [[nodiscard]] std::uint32_t at(std::uint32_t harmonic, std::uint32_t b, std::uint32_t a, std::uint32_t b_less,
                                 std::uint32_t a_less) const {
    if (b < b_less || a < a_less) return 0;
    const std::uint32_t n = basis_.number(harmonic, b - b_less, a - a_less);
    return n == Harmonic::kNone ? 0 : std::min(size_of(field_[n]), 1U << 12U);
  }

  const SeriesBasis& basis_;
  std::span<const std::int32_t> field_;
  std::span<const std::int32_t> first_;  ///< empty for the first field itself
};

void put_size(RangeEncoder& out, std::span<DecisionCounts> steps, std::uint32_t more) {
  for (std::uint32_t k = 0; k < kMostUnary; ++k) {
    out.put(more > k, steps[std::min<std::size_t>(k, kStepContexts - 1)]);
    if (more == k) return;
  }
  const std::uint32_t rest = more - kMostUnary + 1;
  const auto bits = static_cast<unsigned>(std::bit_width(rest)) - 1;
  for (unsigned k = 0; k < bits; ++k) out.put_plain(true);
  out.put_plain(false);
  for (unsigned k = bits; k-- > 0;) out.put_plain(((rest >> k) & 1U) != 0);
}

// kCoefficientEnd for what is none.
std::uint32_t take_size(RangeDecoder& in, std::span<DecisionCounts> steps) {
  for (std::uint32_t k = 0; k < kMostUnary; ++k) {
    if (!in.take(steps[std::min<std::size_t>(k, kStepContexts - 1)])) return k;
  }
  unsigned bits = 0;
  while (in.take_plain()) {
    if (++bits > kMostExtraBits) return kCoefficientEnd;
  }
  std::uint32_t rest = 1;
  for (unsigned k = 0; k < bits; ++k) rest = rest << 1U | (in.take_plain() ? 1U : 0U);
  return rest - 1 + kMostUnary;
}

}  // namespace

std::uint32_t coded_terms(std::span<const std::int32_t> coefficients) {
  std::size_t count = coefficients.size();
  while (count > 0 && coefficients[count - 1] == 0) --count;
  return static_cast<std::uint32_t>(count);
}

std::vector<std::byte> code_coefficients(const SeriesBasis& basis, std::span<const std::vector<std::int32_t>> fields) {
  Contexts contexts;
  RangeEncoder out;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    // Only what the reader knows by then is looked at: neighbours come before, as terms are ordered.
    const Neighbours neighbours(basis, fields[f], f == 0 ? std::span<const std::int32_t>() : fields[0]);
    const std::uint32_t count = coded_terms(fields[f]);
    for (std::uint32_t n = 0; n < count; ++n) {
      const std::int32_t q = fields[f][n];
      const std::size_t kind = neighbours.class_of(n);
      out.put(q != 0, contexts.zero[f == 0 ? 0 : 1][kind]);
      if (q == 0) continue;
      out.put_plain(q < 0);
      put_size(out, contexts.larger[kind / 2], static_cast<std::uint32_t>(std::abs(q)) - 1);
    }
  }
  return out.finish();
}

Result<std::vector<std::vector<std::int32_t>>> decode_coefficients(const SeriesBasis& basis,
                                                                   std::span<const std::byte> stream,
                                                                   std::span<const std::uint32_t> counts,
                                                                   std::uint32_t most_level) {
  Contexts contexts;
  RangeDecoder in(stream);
  std::vector<std::vector<std::int32_t>> fields(counts.size(), std::vector<std::int32_t>(basis.terms.size()));
  for (std::size_t f = 0; f < counts.size(); ++f) {
    const Neighbours neighbours(basis, fields[f], f == 0 ? std::span<const std::int32_t>() : fields[0]);
    for (std::uint32_t n = 0; n < counts[f]; ++n) {
      const std::size_t kind = neighbours.class_of(n);
      if (!in.take(contexts.zero[f == 0 ? 0 : 1][kind])) continue;
      const bool negative = in.take_plain();
      const std::uint32_t more = take_size(in, contexts.larger[kind / 2]);
      if (more + 1 >= static_cast<std::uint32_t>(kCoefficientEnd)) return invalid_file("a coefficient of 2^24 or more");
      fields[f][n] = negative ? -static_cast<std::int32_t>(more + 1) : static_cast<std::int32_t>(more + 1);
    }
  }
  for (std::vector<std::int32_t>& field : fields) {
    for (std::size_t n = 0; n < field.size(); ++n) {
      if (basis.terms[n].level > most_level) field[n] = 0;
    }
  }
  return fields;
}

}  // namespace sbrdf::internal
