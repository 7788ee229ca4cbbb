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

TEST_F(MaterialTest, TellsTheVersion) { EXPECT_STREQ(sbrdf::version(), SBRDF_VERSION); }

}  // namespace
