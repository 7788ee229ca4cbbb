// Uniform samples in HDF5.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "converters/baselines/scheme_samples.h"
#include "converters/files/format_table.h"
#include "converters/files/hdf5/hdf5_file.h"
#include "converters/models/analytic.h"
#include "formats/table/hdf5/samples.h"
#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using small_files::Bytes;
using small_files::source_of;
using testing::HasSubstr;

Bytes saved(const BrdfSource& source, const Options& options) {
  MemorySink sink;
  Report report;
  const Status done = save_hdf5(source, sink, options, report, {});
  EXPECT_TRUE(done) << (done ? "" : done.error().message);
  return std::move(sink).take();
}

std::unique_ptr<BrdfSource> wood() { return make_analytic_source(kurt_material("wood01").value()); }

Options scheme_options(const std::string& scheme = "3") {
  Options options;
  options.set("scheme", scheme);
  return options;
}

/// Of two directions on a ring and the normal.
Hdf5Samples small_samples() {
  return {.scheme = "mine",
          .ring_theta_deg = {0, 50},
          .ring_count = {1, 3},
          .channels = {"Y"},
          .values = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
          .interpolation = "barycentric",
          .kernel = "",
          .description = "made up"};
}

Result<std::unique_ptr<BrdfSource>> opened(const Hdf5Samples& samples, const Options& options = {}) {
  MemorySink sink;
  EXPECT_TRUE(write_hdf5_samples(sink, samples, "{}", 4));
  return open_hdf5(source_of(std::move(sink).take()), options);
}

TEST(Hdf5Samples, ComeBackBitForBit) {
  for (const auto& [interpolation, kernel] :
       std::vector<std::pair<std::string, std::string>>{{"barycentric", ""}, {"rbf", ""}, {"rbf", "thin-plate"}}) {
    Options options = scheme_options();
    options.set("interpolation", interpolation);
    if (!kernel.empty()) options.set("rbf-kernel", kernel);
    const Bytes bytes = saved(*wood(), options);
    EXPECT_EQ(bytes, saved(*wood(), options)) << "the same each time";
    const auto source = open_hdf5(source_of(bytes), {}).value();
    ASSERT_NE(source->uniform_samples(), nullptr);
    const SchemeSource& samples = *source->uniform_samples();
    const UniformScheme scheme = paper_scheme("3").value();
    EXPECT_EQ(samples.samples().values, sample_scheme(*wood(), scheme).value().values);
    EXPECT_EQ(samples.samples().scheme.name, "3");
    EXPECT_EQ(name_of(kInterpolationNames, samples.interpolation().kind), interpolation);
    EXPECT_EQ(name_of(kRbfKernelNames, samples.interpolation().kernel), kernel.empty() ? "cubic" : kernel);
    EXPECT_EQ(source->traits().channels, wood()->traits().channels);
    EXPECT_EQ(source->traits().theta_max_deg, 80);
    EXPECT_EQ(saved(*source, {}), bytes) << "copied";
  }
}

TEST(Hdf5Samples, AreInterpolatedAsTheReaderSays) {
  const Bytes bytes = saved(*wood(), scheme_options());
  Options rbf;
  rbf.set("interpolation", "rbf");
  const auto source = open_hdf5(source_of(bytes), rbf).value();
  EXPECT_EQ(source->uniform_samples()->interpolation().kind, Interpolation::Kind::kRbf);
  const Bytes again = saved(*source, rbf);
  const auto reread = open_hdf5(source_of(again), {}).value();
  EXPECT_EQ(reread->uniform_samples()->interpolation().kind, Interpolation::Kind::kRbf);
  EXPECT_EQ(reread->uniform_samples()->samples().values, source->uniform_samples()->samples().values);
}

TEST(Hdf5Samples, KeepWhatTheyAreOfAndTakeAKernelForRbf) {
  const auto source = open_hdf5(source_of(saved(*wood(), scheme_options())), {}).value();
  Options kernel;
  kernel.set("rbf-kernel", "linear");
  const auto again = open_hdf5(source_of(saved(*source, kernel)), {}).value();
  EXPECT_EQ(again->uniform_samples()->interpolation().kind, Interpolation::Kind::kRbf);
  EXPECT_EQ(again->uniform_samples()->interpolation().kernel, RbfKernel::kLinear);
  EXPECT_EQ(again->uniform_samples()->samples().description, wood()->traits().description);
  EXPECT_THAT(again->traits().description, HasSubstr("wood01"));
}

TEST(Hdf5Samples, ClampNegativesAndSayWhereNothingWasMeasured) {
  Hdf5Samples samples = small_samples();
  samples.values[2] = -3;
  samples.theta_max_deg = 45;
  const auto kept = opened(samples).value();
  EXPECT_EQ(kept->uniform_samples()->samples().values[2], -3);
  EXPECT_EQ(kept->traits().theta_max_deg, 45);
  EXPECT_EQ(opened(samples, Options().set("negatives", "clamp")).value()->uniform_samples()->samples().values[2], 0);
  EXPECT_FALSE(opened(samples, Options().set("negatives", "unmeasured")));
  MemorySink sink;
  Report report;
  Options beyond;
  beyond.set("scheme", "1");
  ASSERT_TRUE(save_hdf5(*kept, sink, beyond, report, {}));
  EXPECT_TRUE(std::any_of(report.remarks.begin(), report.remarks.end(),
                          [](const Remark& remark) { return remark.key == "beyond_theta_max"; }));
  const auto reread = open_hdf5(source_of(std::move(sink).take()), {}).value();
  EXPECT_EQ(reread->traits().theta_max_deg, 45);
}

TEST(Hdf5Samples, BecomeADenseTableWhereAGridIsAskedFor) {
  const auto source = open_hdf5(source_of(saved(*wood(), scheme_options())), {}).value();
  Options grid;
  grid.set("grid", "angles/45:60:45:60");
  const auto dense = open_hdf5(source_of(saved(*source, grid)), {}).value();
  EXPECT_EQ(dense->uniform_samples(), nullptr);
  EXPECT_NE(dense->table(), nullptr);
}

TEST(Hdf5Samples, RefuseOptionsOfDenseTables) {
  MemorySink sink;
  Report report;
  Options options;
  options.set("interpolation", "rbf");
  const Status written = save_hdf5(*wood(), sink, options, report, {});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kUsage);
  for (const char* dense : {"grid", "type"}) {
    Options both = scheme_options();
    both.set(dense, "x");
    EXPECT_EQ(check_hdf5_options(both).error().code, ErrorCode::kUsage);
  }
  Options kernel = scheme_options();
  kernel.set("interpolation", "barycentric").set("rbf-kernel", "linear");
  EXPECT_EQ(check_hdf5_options(kernel).error().code, ErrorCode::kUsage);
  const Status nowhere = check_options(scheme_options("nowhere.json"), hdf5_options(), OptionUse::kWrite, "files");
  EXPECT_THAT(nowhere.error().message, HasSubstr("nowhere.json: "));
  EXPECT_TRUE(check_hdf5_options(scheme_options()));
  for (const std::string scheme : {"31", "", "nowhere.json"}) {
    EXPECT_FALSE(save_hdf5(*wood(), sink, scheme_options(scheme), report, {})) << scheme;
  }
}

TEST(Hdf5Samples, RefuseFilesThatContradictThemselves) {
  ASSERT_TRUE(opened(small_samples()));
  const auto refusal = [](const auto& change, ErrorCode code = ErrorCode::kInvalidFile) {
    Hdf5Samples samples = small_samples();
    change(samples);
    const auto source = opened(samples);
    if (source) return std::string("taken");
    EXPECT_EQ(source.error().code, code) << source.error().message;
    return source.error().message;
  };
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.values.pop_back(); }), HasSubstr("has 9 rows, and the scheme 10 pairs"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_count.push_back(3); }), HasSubstr("are not of one length"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_count[1] = 2.5; }), HasSubstr("2.5 at 1"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_count[1] = -3; }), HasSubstr("no number of directions"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_count[1] = std::nan(""); }), HasSubstr("no number of directions"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_count[1] = 1e300; }), HasSubstr("no number of directions"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_theta_deg[1] = 95; }), HasSubstr("is not below 90"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.ring_theta_deg[1] = std::nan(""); }), HasSubstr("is not above"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.values[4] = std::numeric_limits<float>::infinity(); }),
              HasSubstr("not finite, in row 4"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) {
                s.channels = {"a", "a"}, s.values.resize(20, 1);
              }),
              HasSubstr("two channels have one name"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.interpolation = ""; }), HasSubstr("\"interpolation\" is missing"));
  EXPECT_THAT(
      refusal([](Hdf5Samples& s) { s.ring_count[1] = 3, s.ring_theta_deg[1] = 1e-12; }, ErrorCode::kUnsupported),
      HasSubstr("cannot be triangulated"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.interpolation = "magic"; }, ErrorCode::kUnsupported), HasSubstr("magic"));
  EXPECT_THAT(refusal([](Hdf5Samples& s) { s.interpolation = "rbf", s.kernel = "x"; }, ErrorCode::kUnsupported),
              HasSubstr("\"x\" is no kernel"));
}

TEST(Hdf5Samples, AreRefusedWhereTheirEndIsMissing) {
  const Bytes bytes = saved(*wood(), scheme_options("1"));
  for (std::size_t size : {0UL, 8UL, 96UL, bytes.size() / 2, bytes.size() - 1}) {
    EXPECT_FALSE(open_hdf5(source_of(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))), {}));
  }
}

}  // namespace
}  // namespace sbrdf::internal
