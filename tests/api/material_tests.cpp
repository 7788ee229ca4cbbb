// Knows nothing of the library but its installed header.
#include <gmock/gmock.h>
#include <sbrdf/sbrdf.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

namespace {

namespace fs = std::filesystem;
using sbrdf::DirectionPair;
using sbrdf::ErrorCode;
using sbrdf::Material;
using sbrdf::pair_from_degrees;

constexpr double kRightAngle = 1.5707963267948966;  // the double below pi / 2

/// A folder of its own for each test, gone afterwards.
class MaterialTest : public testing::Test {
 protected:
  MaterialTest() {
    std::string name = (fs::temp_directory_path() / "sbrdf-api-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~MaterialTest() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// kurt:fabric112 in few samples.
  [[nodiscard]] std::string small_file(const std::string& name, sbrdf::Options more = {}) const {
    more.insert({"placement", "28/60"});
    more.insert({"samples", "900"});
    more.insert({"values", "measured"});
    more.insert({"precision", "lossless"});
    const auto saved = open("kurt:fabric112").save(path(name), {more, {}});
    EXPECT_TRUE(saved) << (saved ? "" : saved.error().message);
    return path(name);
  }
  static Material open(const std::string& name, const sbrdf::OpenOptions& options = {}) {
    auto material = Material::open(name, options);
    if (!material) throw std::runtime_error(name + ": " + material.error().message);
    return *std::move(material);
  }

  fs::path folder_;
};

std::vector<std::byte> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::vector<float> values_of(const Material& material, const DirectionPair& pair) {
  std::vector<float> values(material.channel_count(), -1);
  material.evaluate(pair, values);
  return values;
}

std::vector<DirectionPair> some_pairs(int count) {
  std::vector<DirectionPair> pairs;
  // Not at nodes of a lattice: there a rounding decides between two cells.
  for (int k = 0; k < count; ++k) {
    pairs.push_back(pair_from_degrees(0.3 + k * 37 % 89, 0.7 + k * 71, 0.2 + k * 53 % 87, k * 13));
  }
  return pairs;
}

ErrorCode code_of(const sbrdf::Result<Material>& result) {
  EXPECT_FALSE(result);
  return result ? ErrorCode{} : result.error().code;
}

TEST_F(MaterialTest, OpensTheSameFromAPathFromMemoryAndByRanges) {
  for (const char* const name : {"m.sbrdf", "m.binary"}) {
    const std::string file = name == std::string("m.sbrdf") ? small_file(name) : path(name);
    if (name == std::string("m.binary")) {
      ASSERT_TRUE(open(small_file("for_table.sbrdf")).save(file, {{{"merl-shape", "20,20,40"}}, {}}));
    }
    const std::vector<std::byte> bytes = bytes_of(file);
    const Material by_path = open(file);
    const auto by_memory = Material::open(bytes);
    const auto read = [&](std::uint64_t offset, std::span<std::byte> target) -> std::optional<sbrdf::Error> {
      std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), target.size(), target.begin());
      return {};
    };
    const auto by_ranges = Material::open(bytes.size(), read);
    ASSERT_TRUE(by_memory && by_ranges) << name;
    for (const DirectionPair& pair : some_pairs(50)) {
      const std::vector<float> expected = values_of(by_path, pair);
      EXPECT_EQ(values_of(*by_memory, pair), expected) << name;
      EXPECT_EQ(values_of(*by_ranges, pair), expected) << name;
    }
  }
}

TEST_F(MaterialTest, TellsTraitsAndMetadata) {
  const Material kurt = open("kurt:fabric112");
  EXPECT_EQ(kurt.traits().format, "kurt");
  EXPECT_THAT(kurt.traits().channels, testing::ElementsAre("R", "G", "B"));
  EXPECT_TRUE(kurt.traits().reciprocal);
  EXPECT_FALSE(kurt.traits().isotropic);
  EXPECT_EQ(kurt.metadata(), "");

  const Material sliced = open(small_file("m.sbrdf"));
  EXPECT_EQ(sliced.traits().format, "sbrdf");
  EXPECT_THAT(sliced.metadata(), testing::StartsWith("{"));
  EXPECT_THAT(sliced.metadata(), testing::HasSubstr("kurt"));
}

TEST_F(MaterialTest, GivesOneValueHoweverItIsAskedFor) {
  const Material material = open(small_file("m.sbrdf"));
  const std::vector<DirectionPair> pairs = some_pairs(3000);
  std::vector<float> many(pairs.size() * 3);
  material.evaluate(pairs, many);

  std::vector<std::array<float, 3>> w_i, w_v;
  const auto vector_of = [](const sbrdf::Direction& d) {
    return std::array{static_cast<float>(2 * std::sin(d.theta) * std::cos(d.phi)),
                      static_cast<float>(2 * std::sin(d.theta) * std::sin(d.phi)),
                      static_cast<float>(2 * std::cos(d.theta))};
  };
  for (const DirectionPair& pair : pairs) w_i.push_back(vector_of(pair.i)), w_v.push_back(vector_of(pair.v));
  std::vector<float> of_vectors(many.size());
  material.evaluate(w_i, w_v, of_vectors);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_EQ(values_of(material, pairs[k]), std::vector<float>(many.begin() + 3 * k, many.begin() + 3 * k + 3));
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(of_vectors[3 * k + c], many[3 * k + c], 1e-4 * std::abs(many[3 * k + c]) + 1e-6) << k;
    }
  }
}

TEST_F(MaterialTest, IsZeroBelowTheHorizonWhateverTheFormat) {
  ASSERT_TRUE(open(small_file("m.sbrdf")).save(path("m.binary"), {{{"merl-shape", "20,20,40"}}, {}}));
  for (const std::string& name : {path("m.sbrdf"), path("m.binary"), std::string("kurt:wood01")}) {
    const Material material = open(name);
    const double below = std::nextafter(kRightAngle, 2);
    EXPECT_THAT(values_of(material, {{0.5, 0}, {below + 1e-9, 1}}), testing::Each(0.0F)) << name;
    EXPECT_THAT(values_of(material, {{2.5, 0}, {0.1, 1}}), testing::Each(0.0F)) << name;
    EXPECT_THAT(values_of(material, {{0.5, 0}, {1.3, 1}}), testing::Each(testing::Gt(0.0F))) << name;
    EXPECT_THAT(values_of(material, {{0.5, std::nan("")}, {0.5, 0}}), testing::Each(0.0F)) << name;
    EXPECT_THAT(values_of(material, {{0.5, 0}, {-HUGE_VAL, 0}}), testing::Each(0.0F)) << name;
    std::vector<float> values(3, -1);
    const std::array<std::array<float, 3>, 1> up = {{{0, 0, 1}}}, down = {{{0, 0.6F, -0.8F}}};
    material.evaluate(up, down, values);
    EXPECT_THAT(values, testing::Each(0.0F)) << name;
  }
}

TEST_F(MaterialTest, LoadsAPartThatKnowsWhatItCovers) {
  const std::string file = small_file("m.sbrdf", {{"chunks", "split"}});
  const Material whole = open(file);
  const DirectionPair inside = pair_from_degrees(30, 0, 45, 180), outside = pair_from_degrees(75, 10, 10, 300);
  sbrdf::OpenOptions options;
  options.part = sbrdf::Part{};
  options.part->pairs = {inside};
  const Material part = open(file, options);
  EXPECT_TRUE(part.covers(inside));
  EXPECT_EQ(values_of(part, inside), values_of(whole, inside));
  EXPECT_FALSE(part.covers(outside));
  EXPECT_TRUE(whole.covers(outside));
  EXPECT_THAT(values_of(part, outside), testing::Each(testing::IsNan()));
  EXPECT_THAT(values_of(part, {{2, 0}, {0, 0}}), testing::Each(0.0F));

  options.part = sbrdf::Part{.theta_max_deg = 40};
  const Material low = open(file, options);
  EXPECT_TRUE(low.covers(pair_from_degrees(39, 100, 20, 0)));
  EXPECT_FALSE(low.covers(outside));

  options.part = sbrdf::Part{.level = 0};
  const Material coarse = open(file, options);
  EXPECT_TRUE(coarse.covers(outside));
  EXPECT_NE(values_of(coarse, inside), values_of(whole, inside));

  EXPECT_EQ(part.save(path("part.sbrdf")).error().code, ErrorCode::kUnsupported);
  EXPECT_FALSE(fs::exists(path("part.sbrdf")));
  EXPECT_EQ(code_of(Material::open("kurt:wood01", options)), ErrorCode::kUnsupported);
  options.format["no-such-option"] = "1";
  EXPECT_EQ(code_of(Material::open(file, options)), ErrorCode::kUsage);
  options.format.clear();
  options.part->level = 17;
  EXPECT_EQ(code_of(Material::open(file, options)), ErrorCode::kUsage);
  options.part = sbrdf::Part{.theta_max_deg = std::nan("")};
  EXPECT_EQ(code_of(Material::open(file, options)), ErrorCode::kUsage);
}

TEST_F(MaterialTest, ReadsOnlyWhatAPartNeeds) {
  const std::vector<std::byte> bytes = bytes_of(small_file("m.sbrdf", {{"chunks", "split"}, {"samples", "4000"}}));
  std::atomic<std::uint64_t> taken = 0;
  const auto read = [&](std::uint64_t offset, std::span<std::byte> target) -> std::optional<sbrdf::Error> {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), target.size(), target.begin());
    taken += target.size();
    return {};
  };
  sbrdf::OpenOptions options;
  options.part = sbrdf::Part{};
  options.part->pairs = {pair_from_degrees(30, 0, 45, 180)};
  const auto part = Material::open(bytes.size(), read, options);
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_LT(taken, bytes.size() / 2);
}

TEST_F(MaterialTest, HandsOnTheErrorOfACallback) {
  const auto read = [&](std::uint64_t offset, std::span<std::byte>) -> std::optional<sbrdf::Error> {
    return sbrdf::Error{ErrorCode::kIo, "the line is dead", offset};
  };
  const auto material = Material::open(1000, read);
  ASSERT_EQ(code_of(material), ErrorCode::kIo);
  EXPECT_EQ(material.error().message, "the line is dead");
}

TEST_F(MaterialTest, SaysWhatIsWrongWithWhatCannotBeOpened) {
  EXPECT_EQ(code_of(Material::open(path("missing"))), ErrorCode::kIo);
  EXPECT_EQ(code_of(Material::open(folder_.string())), ErrorCode::kIo);
  EXPECT_EQ(code_of(Material::open("kurt:nobody")), ErrorCode::kUsage);
  EXPECT_EQ(code_of(Material::open(std::vector<std::byte>{})), ErrorCode::kInvalidFile);
  std::vector<std::byte> cut = bytes_of(small_file("m.sbrdf"));
  cut.pop_back();
  const auto material = Material::open(cut);
  ASSERT_EQ(code_of(material), ErrorCode::kInvalidFile);
  EXPECT_THAT(material.error().message, testing::StartsWith("[SB-3-2]"));
  EXPECT_EQ(code_of(Material::open("kurt:wood01", {{}, {{"no-such-option", "1"}}})), ErrorCode::kUsage);
}

TEST_F(MaterialTest, SavesToAFileAndToMemoryTheSame) {
  const std::string file = small_file("m.sbrdf");
  const Material material = open(file);
  const auto report = material.save(path("copy.SBRDF"));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->format, "sbrdf");
  EXPECT_EQ(report->bytes, fs::file_size(path("copy.SBRDF")));
  EXPECT_EQ(bytes_of(path("copy.SBRDF")), bytes_of(file));

  const auto in_memory = material.save_to_memory(".binary", {{{"merl-shape", "10,10,20"}}, {}});
  ASSERT_TRUE(in_memory);
  EXPECT_EQ(in_memory->bytes.size(), 12U + 3 * 8 * 10 * 10 * 20);
  EXPECT_EQ(in_memory->report.bytes, in_memory->bytes.size());
  EXPECT_THAT(in_memory->report.remarks, testing::Not(testing::IsEmpty()));
}

TEST_F(MaterialTest, RefusesToSaveWhatItShould) {
  const Material material = open("kurt:fabric112");
  EXPECT_EQ(material.save(path("m.nothing")).error().code, ErrorCode::kUsage);
  EXPECT_EQ(material.save(path("nowhere/m.sbrdf")).error().code, ErrorCode::kIo);
  EXPECT_EQ(material.save(path("m.sbrdf"), {{{"samples", "many"}}, {}}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(material.save(path("m.sbrdf"), {{{"no-such-option", ""}}, {}}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(material.save(path("m.sbrdf"), {{{"max-bytes", "10"}, {"placement", "28/180"}}, {}}).error().code,
            ErrorCode::kDifference);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(MaterialTest, StopsWhenProgressSaysSo) {
  int calls = 0;
  const sbrdf::SaveOptions options = {{}, [&](double fraction) {
                                        EXPECT_GT(fraction, 0);
                                        return ++calls < 2;
                                      }};
  const auto report = open("kurt:fabric112").save(path("m.binary"), options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::kIo);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(MaterialTest, ServesManyThreads) {
  const Material material = open(small_file("m.sbrdf"));
  const std::vector<DirectionPair> pairs = some_pairs(2000);
  std::vector<float> expected(pairs.size() * 3);
  material.evaluate(pairs, expected);
  std::vector<std::vector<float>> found(4, std::vector<float>(expected.size()));
  std::vector<std::thread> threads;
  for (std::vector<float>& values : found) threads.emplace_back([&, copy = material] { copy.evaluate(pairs, values); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(found, testing::Each(expected));
}

using Vector = std::array<float, 3>;

Vector vector_of(const sbrdf::Direction& d) {
  return {static_cast<float>(std::sin(d.theta) * std::cos(d.phi)),
          static_cast<float>(std::sin(d.theta) * std::sin(d.phi)), static_cast<float>(std::cos(d.theta))};
}

Vector vector_of(double theta_deg, double phi_deg) { return vector_of(pair_from_degrees(theta_deg, phi_deg, 0, 0).i); }

/// As many as asked for, the same every time: multiples of the golden ratio and of the root of 2.
struct Draws {
  std::vector<Vector> w_i;
  std::vector<std::array<float, 2>> u;

  explicit Draws(int count) {
    for (int k = 1; k <= count; ++k) {
      w_i.push_back(vector_of(0.3 + k * 37 % 89, k * 71));
      u.push_back({static_cast<float>(std::fmod(0.618033988749895 * k, 1)),
                   static_cast<float>(std::fmod(1.414213562373095 * k, 1))});
    }
  }
};

TEST_F(MaterialTest, DrawsWhatItEvaluatesAndTellsItsDensity) {
  for (const std::string& name : {std::string("kurt:fabric112"), small_file("m.sbrdf")}) {
    const Material material = open(name);
    const Draws draws(2000);
    std::vector<sbrdf::Sample> samples(draws.u.size());
    std::vector<float> values(draws.u.size() * 3);
    material.sample(draws.w_i, draws.u, samples, values);
    std::vector<Vector> w_v;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      std::array<float, 3> one{};
      const sbrdf::Sample sample = material.sample(draws.w_i[k], draws.u[k], one);
      EXPECT_EQ(sample.w_v, samples[k].w_v);
      EXPECT_EQ(sample.pdf, samples[k].pdf);
      EXPECT_TRUE(std::equal(one.begin(), one.end(), values.begin() + static_cast<std::ptrdiff_t>(3 * k)));
      EXPECT_EQ(material.pdf(draws.w_i[k], sample.w_v), sample.pdf);
      EXPECT_GT(sample.pdf, 0);
      w_v.push_back(sample.w_v);
    }
    std::vector<float> expected(values.size());
    material.evaluate(draws.w_i, w_v, expected);
    EXPECT_EQ(values, expected);
  }
}

TEST_F(MaterialTest, DrawsForAnglesAsForVectors) {
  const Material material = open("kurt:fabric112");
  for (const DirectionPair& pair : some_pairs(200)) {
    std::array<float, 3> values{};
    std::array<float, 3> expected{};
    EXPECT_EQ(material.sample(pair.i, {0.3F, 0.6F}, values).w_v,
              material.sample(vector_of(pair.i), {0.3F, 0.6F}, expected).w_v);
    EXPECT_EQ(values, expected);
    EXPECT_EQ(material.pdf(pair), material.pdf(vector_of(pair.i), vector_of(pair.v)));
  }
  std::array<float, 3> values{};
  EXPECT_EQ(material.sample(sbrdf::Direction{1.6, 0}, {0.3F, 0.6F}, values).pdf, 0);
  EXPECT_EQ(material.pdf({{0.1, std::nan("")}, {0.2, 0}}), 0);
}

// The share of the light that comes back, by the cosine's rule of midpoints, too.
TEST_F(MaterialTest, DrawsSoThatMeansAreRight) {
  const Material material = open(small_file("m.sbrdf"));
  const Vector w_i = vector_of(50, 30);
  const Draws draws(200'000);
  const std::vector<Vector> lights(draws.u.size(), w_i);
  std::vector<sbrdf::Sample> samples(draws.u.size());
  std::vector<float> values(draws.u.size() * 3);
  material.sample(lights, draws.u, samples, values);
  constexpr int kSteps = 400;
  for (std::size_t c = 0; c < 3; ++c) {
    double drawn = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      drawn += static_cast<double>(values[3 * k + c] * samples[k].w_v[2] / samples[k].pdf);
    }
    drawn /= static_cast<double>(samples.size());
    double summed = 0;
    for (int a = 0; a < kSteps; ++a) {
      const double sine = std::sqrt((a + 0.5) / kSteps);
      for (int b = 0; b < kSteps; ++b) {
        const sbrdf::Direction v = {std::asin(sine), 2 * 3.14159265358979 * (b + 0.5) / kSteps};
        summed += static_cast<double>(values_of(material, {pair_from_degrees(50, 30, 0, 0).i, v})[c]);
      }
    }
    summed *= 3.14159265358979 / (kSteps * kSteps);
    EXPECT_NEAR(drawn, summed, 0.002 * summed) << c;
  }
}

TEST_F(MaterialTest, DrawsNothingOnTheHorizonOrBelow) {
  const float nan = std::nanf("");
  const Material material = open("kurt:wood01");
  const Vector up = {0, 0.1F, 0.9F};
  for (const Vector& none : {Vector{1, 0, 0}, Vector{0, 0.1F, -1}, Vector{0, 0, 0}, Vector{nan, 0, 1}}) {
    std::array<float, 3> values = {1, 2, 3};
    const sbrdf::Sample sample = material.sample(none, {0.2F, 0.4F}, values);
    EXPECT_EQ(sample.pdf, 0);
    EXPECT_EQ(sample.w_v, (Vector{0, 0, 1}));
    EXPECT_THAT(values, testing::Each(0.0F));
    EXPECT_EQ(material.pdf(none, up), 0);
    EXPECT_EQ(material.pdf(up, none), 0);
  }
}

TEST_F(MaterialTest, DrawsFromAPart) {
  sbrdf::OpenOptions options;
  options.part = sbrdf::Part{.theta_max_deg = 40};
  const Material part = open(small_file("m.sbrdf"), options);
  const Draws draws(2000);
  int covered = 0;
  for (std::size_t k = 0; k < draws.u.size(); ++k) {
    std::array<float, 3> values{};
    const Vector w_i = vector_of(10 + static_cast<double>(k % 25), 20);
    const sbrdf::Sample sample = part.sample(w_i, draws.u[k], values);
    const DirectionPair pair = {
        {std::acos(static_cast<double>(w_i[2])), std::atan2(w_i[1], w_i[0])},
        {std::acos(static_cast<double>(sample.w_v[2])), std::atan2(sample.w_v[1], sample.w_v[0])}};
    EXPECT_GT(sample.pdf, 0);
    EXPECT_EQ(part.pdf(w_i, sample.w_v), sample.pdf);
    EXPECT_EQ(std::isfinite(values[0]), part.covers(pair)) << k;
    covered += part.covers(pair) ? 1 : 0;
  }
  EXPECT_GT(covered, 1600);
}

// All of them ask first.
TEST_F(MaterialTest, DrawsTheSameOnManyThreads) {
  const Draws draws(3000);
  const auto draw_all = [&](const Material& material) {
    std::vector<float> values(draws.u.size() * 3);
    std::vector<sbrdf::Sample> samples(draws.u.size());
    material.sample(draws.w_i, draws.u, samples, values);
    for (const sbrdf::Sample& sample : samples) values.insert(values.end(), sample.w_v.begin(), sample.w_v.end());
    return values;
  };
  const std::string file = small_file("m.sbrdf");
  const std::vector<float> expected = draw_all(open(file));
  const Material material = open(file);
  std::vector<std::vector<float>> drawn(8);
  {
    std::vector<std::jthread> threads;
    for (std::vector<float>& own : drawn) threads.emplace_back([&] { own = draw_all(material); });
  }
  for (const std::vector<float>& own : drawn) EXPECT_EQ(own, expected);
}

TEST_F(MaterialTest, TellsTheVersion) { EXPECT_STREQ(sbrdf::version(), SBRDF_VERSION); }

// Values for vectors in another form, against those of the exact one; angles and files stay what they are.
TEST_F(MaterialTest, HasOtherFormsForManyValues) {
  std::ofstream(path("gloss.json"))
      << R"({"name": "gloss", "k_d": [0.1, 0.05, 0.02], "lobes": [{"k_s": [0.1, 0.1, 0.1],)"
         R"( "f_0": 0.2, "m_x": 0.3, "m_y": 0.3, "alpha": 0}]})";
  const auto saved =
      open(path("gloss.json")).save(path("gloss.sbrdf"), {{{"samples", "600"}, {"search-evaluations", "1"}}, {}});
  ASSERT_TRUE(saved) << saved.error().message;
  const Material exact = open(path("gloss.sbrdf"));
  std::vector<std::array<float, 3>> w_i;
  std::vector<std::array<float, 3>> w_v;
  for (int k = 0; k < 500; ++k) {
    const auto angle = static_cast<float>(k);
    w_i.push_back({std::sin(angle), std::cos(angle), 0.3F + 0.01F * angle});
    w_v.push_back({std::cos(3 * angle), std::sin(2 * angle), 0.2F + 0.004F * angle});
  }
  const std::size_t channels = exact.channel_count();
  std::vector<float> expected(w_i.size() * channels);
  std::vector<float> values(expected.size());
  exact.evaluate(w_i, w_v, expected);
  for (const sbrdf::Form form : {sbrdf::Form::kExact, sbrdf::Form::kPresampled, sbrdf::Form::kDense}) {
    const auto other = exact.in_form(form);
    ASSERT_TRUE(other) << other.error().message;
    other->evaluate(w_i, w_v, values);
    double sum = 0;
    double most = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double error = std::abs(values[k] / static_cast<double>(expected[k]) - 1);
      sum += error;
      most = std::max(most, error);
    }
    EXPECT_EQ(most == 0, form == sbrdf::Form::kExact);
    EXPECT_LT(most, form == sbrdf::Form::kPresampled ? 4 * 0.0005 : 0.2);
    EXPECT_LT(sum / static_cast<double>(values.size()), 0.01);
    std::vector<float> one(channels);
    std::vector<float> exact_one(channels);
    other->evaluate(pair_from_degrees(30, 0, 45, 180), one);
    exact.evaluate(pair_from_degrees(30, 0, 45, 180), exact_one);
    EXPECT_EQ(one, exact_one);
    EXPECT_EQ(other->save_to_memory(".sbrdf")->bytes, bytes_of(path("gloss.sbrdf")));
  }
}

TEST_F(MaterialTest, RefusesFormsOfWhatHasNone) {
  const Material sliced = open(small_file("cloth.sbrdf"));
  EXPECT_TRUE(sliced.in_form(sbrdf::Form::kPresampled));
  const auto dense = sliced.in_form(sbrdf::Form::kDense);
  ASSERT_FALSE(dense);
  EXPECT_EQ(dense.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(dense.error().message, testing::HasSubstr("anisotropic"));
  const auto model = open("kurt:fabric112").in_form(sbrdf::Form::kExact);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, ErrorCode::kUnsupported);
}

}  // namespace
