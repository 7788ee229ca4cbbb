// Counts what is asked of the heap; in a file of its own, as it takes the place of operator new in the whole program.
#include <sbrdf/sbrdf.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

namespace {

std::atomic<std::size_t> allocations = 0;

}  // namespace

// All but the aligned ones, as a sanitizer brings its own of those that are left and looks for pairs.
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new(std::size_t size) {
  void* const memory = operator new(size, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return operator new(size, std::nothrow);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }

namespace {

using sbrdf::Material;

TEST(MaterialAllocations, AreNoneWhenDirectionsAreDrawn) {
  const auto model = Material::open("kurt:fabric112");
  ASSERT_TRUE(model);
  auto saved =
      model->save_to_memory(".sbrdf", {{{"placement", "28/60"}, {"samples", "900"}, {"values", "measured"}}, {}});
  ASSERT_TRUE(saved);
  const auto sliced = Material::open(std::move(saved->bytes));
  ASSERT_TRUE(sliced);
  for (const auto* material : {&*model, &*sliced}) {
    std::array<float, 3> values{};
    const std::array<float, 3> w_i = {0.5F, 0.1F, 0.7F};
    const std::size_t at_first = allocations;
    EXPECT_GT(material->sample(w_i, {0.1F, 0.2F}, values).pdf, 0);
    EXPECT_GT(allocations, at_first) << "making the table is not seen, so nothing is";
    const std::size_t before = allocations;
    float sum = 0;
    for (int k = 0; k < 1000; ++k) {
      const float u = static_cast<float>(k) / 1000;
      sum += material->pdf(w_i, material->sample(w_i, {u, std::fmod(7 * u, 1.0F)}, values).w_v);
    }
    EXPECT_EQ(allocations, before);
    EXPECT_GT(sum, 0);
  }
}

}  // namespace
