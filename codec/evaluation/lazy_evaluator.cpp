#include "codec/evaluation/lazy_evaluator.h"

#include "codec/evaluation/simd/kernel.h"

namespace sbrdf::internal {
namespace {

// A pair alone takes about a hundredth of what all slices take, so that waiting costs twice as much at most.
constexpr std::size_t kAlone = 32;
// But tables of so many numbers are not made again and again, in several threads maybe.
constexpr std::size_t kMostAgain = std::size_t{1} << 20U;

}  // namespace

void LazyEvaluator::evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                             std::span<float> values) const {
  const VectorEvaluator* ready = ready_.load(std::memory_order_acquire);
  const bool large = lattice_.crossings.size() * sliced_.channel_count() > kMostAgain;
  if (ready == nullptr && large) ready = &whole();
  if (ready == nullptr && asked_.fetch_add(w_i.size(), std::memory_order_relaxed) + w_i.size() > kAlone)
    ready = &whole();
  if (ready != nullptr) return ready->evaluate(w_i, w_v, values);
  const SliceTables bare(sliced_, lattice_tables());
  SliceTables::Needs needs;
  for (std::size_t k = 0; k < w_i.size(); ++k) find_needs(bare, &w_i[k].x, &w_v[k].x, needs);
  const SliceTables some(sliced_, lattice_, lattice_tables(), &needs);
  if (!w_i.empty()) evaluate_vectors(some, &w_i.front().x, &w_v.front().x, w_i.size(), values.data());
}

const VectorEvaluator& LazyEvaluator::whole() const {
  std::call_once(whole_made_, [&] {
    whole_.emplace(sliced_, lattice_, lattice_tables());
    ready_.store(&*whole_, std::memory_order_release);
  });
  return *whole_;
}

std::size_t LazyEvaluator::bytes() const {
  const VectorEvaluator* ready = ready_.load(std::memory_order_acquire);
  return ready != nullptr ? ready->bytes() : 0;
}

const std::shared_ptr<const LatticeTables>& LazyEvaluator::lattice_tables() const {
  std::call_once(lattice_made_, [&] { lattice_tables_ = std::make_shared<const LatticeTables>(lattice_); });
  return lattice_tables_;
}

}  // namespace sbrdf::internal
