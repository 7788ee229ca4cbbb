#include "converters/files/klems/klems_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "converters/files/format_table.h"
#include "formats/core/directions.h"
#include "tests/support/small_files.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

struct Centre {
  double theta_deg;
  double phi_deg;
};

/// Centres of the 145 patches, in the order of the matrix.
std::vector<Centre> centres() {
  const std::vector<std::pair<double, int>> rings = {{2.5, 1}, {10, 8},  {20, 16}, {30, 20},  {40, 24},
                                                     {50, 24}, {60, 24}, {70, 16}, {82.5, 12}};
  std::vector<Centre> all;
  for (const auto& [theta, count] : rings) {
    for (int k = 0; k < count; ++k) all.push_back({theta, 360.0 * k / count});
  }
  return all;
}

/// A file of Klems' full basis with a value for the centres of each incident and outgoing patch.
std::string text_of(const std::function<double(const Centre& in, const Centre& out)>& value,
                    const std::string& direction = "Reflection Front") {
  std::string text =
      "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns</"
      "IncidentDataStructure><AngleBasis>"
      "<AngleBasisName>LBNL/Klems "
      "Full</AngleBasisName></AngleBasis></DataDefinition><WavelengthData><Wavelength>Visible"
      "</Wavelength><WavelengthDataBlock><WavelengthDataDirection>" +
      direction +
      "</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Full"
      "</RowAngleBasis><ScatteringData>";
  for (const Centre& out : centres()) {
    for (const Centre& in : centres()) {
      char number[40];
      std::snprintf(number, sizeof number, "%.9g,", value(in, out));
      text += number;
    }
    text += "\n";
  }
  return text + "</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>";
}

Result<std::unique_ptr<BrdfSource>> open(const std::string& text, const Options& options = {}) {
  return open_source(std::make_shared<OwnedMemorySource>(small_files::bytes_of(text)), options);
}

float value_at(const BrdfSource& source, const Centre& light, const Centre& viewer) {
  const DirectionPair pair = {direction_from_degrees(light.theta_deg, light.phi_deg),
                              direction_from_degrees(viewer.theta_deg, viewer.phi_deg)};
  float value = 0;
  source.evaluate(std::span(&pair, 1), std::span(&value, 1));
  return value;
}

double lopsided(const Centre& in, const Centre& out) {
  return 0.1 + in.theta_deg / 1000 + in.phi_deg / 10000 + out.theta_deg / 700 + out.phi_deg / 3000;
}

TEST(KlemsSource, GivesEachPatchItsValueWithTheLightOppositeToItsPatch) {
  const auto source = open(text_of(lopsided));
  ASSERT_TRUE(source.ok()) << source.error().message;
  for (const Centre& in : centres()) {
    for (const Centre& out : centres()) {
      const double expected = lopsided(in, out);
      const Centre light = {in.theta_deg, in.phi_deg + 180};
      ASSERT_NEAR(value_at(**source, light, out), expected, 1e-6 * expected);
      ASSERT_EQ(value_at(**source, {in.theta_deg + 1, in.phi_deg + 187}, {out.theta_deg - 1, out.phi_deg - 7}),
                value_at(**source, light, out));
    }
  }
  EXPECT_EQ((*source)->traits().channels, std::vector<std::string>{"Y"});
  EXPECT_FALSE((*source)->traits().reciprocal);
  EXPECT_EQ((*source)->traits().theta_max_deg, 90);
}

TEST(KlemsSource, AMirrorIsTheDiagonal) {
  const auto source = open(text_of([](const Centre& in, const Centre& out) {
                        return in.theta_deg == out.theta_deg && in.phi_deg == out.phi_deg ? 5.0 : 0.01;
                      })).value();
  for (const double theta : {1.0, 12.0, 33.0, 58.0, 88.0}) {
    for (const double phi : {0.0, 45.0, 123.0, 300.0}) {
      EXPECT_EQ(value_at(*source, {theta, phi}, {theta, phi + 180}), 5) << theta << " " << phi;
      if (theta < 5) continue;  // one patch
      EXPECT_NEAR(value_at(*source, {theta, phi}, {theta, phi}), 0.01, 1e-6);
    }
  }
}

TEST(KlemsSource, AzimuthsAreWhatOptionsSay) {
  const std::string text = text_of(lopsided);
  const Centre in = {50, 75};
  const Centre out = {30, 36};
  const auto light = open(text, Options().set("klems-incident", "light")).value();
  EXPECT_NEAR(value_at(*light, in, out), lopsided(in, out), 1e-6);
  const auto clockwise = open(text, Options().set("klems-azimuth", "clockwise")).value();
  EXPECT_NEAR(value_at(*clockwise, {50, 180 - 75}, {30, -36}), lopsided(in, out), 1e-6);
}

TEST(KlemsSource, TransmissionIsReadWhereItIsAskedFor) {
  const std::string text = text_of(lopsided, "Transmission Front");
  EXPECT_THAT(open(text).error().message, HasSubstr("--klems-transmission"));
  const auto source = open(text, Options().set("klems-transmission")).value();
  EXPECT_NEAR(value_at(*source, {50, 75 + 180}, {30, 36}), lopsided({50, 75}, {30, 36}), 1e-6);
  EXPECT_THAT(source->traits().description, HasSubstr("transmission from the front"));
}

TEST(KlemsFindings, TellTheLargestHemisphericalReflectance) {
  const auto source = open(text_of([](const Centre& in, const Centre&) {
                        return (in.theta_deg > 80 && in.phi_deg == 90 ? 1.2 : 0.7) / std::numbers::pi;
                      })).value();
  const Finding finding = source->traits().findings.at(0);
  EXPECT_THAT(finding.what,
              HasSubstr("reflectance above 1; the largest is 1.2, of patch 137 (theta 75 to 90 degrees)"));
  EXPECT_EQ(finding.count, 1U);
  EXPECT_EQ(finding.total, 145U);
}

TEST(KlemsFindings, CountNegativesAndDoWhatAnOptionSays) {
  const std::string text = text_of(
      [](const Centre& in, const Centre& out) { return in.theta_deg == 50 && out.theta_deg == 2.5 ? -0.1 : 0.1; });
  EXPECT_EQ(open(text).value()->traits().findings.at(1).count, 24U);
  EXPECT_NEAR(value_at(*open(text).value(), {50, 3}, {1, 0}), -0.1, 1e-6);
  EXPECT_EQ(value_at(*open(text, Options().set("negatives", "clamp")).value(), {50, 3}, {1, 0}), 0);
  const auto source = open(text, Options().set("negatives", "unmeasured")).value();
  const DirectionPair pair = {direction_from_degrees(50, 3), direction_from_degrees(1, 0)};
  std::uint8_t flag = 1;
  source->measured(std::span(&pair, 1), std::span(&flag, 1));
  EXPECT_EQ(flag, 0);
  EXPECT_TRUE(source->mask_grid().has_value() && source->mask_grid()->is_valid());
}

TEST(KlemsSource, IsZeroBelowTheHorizonAndRefusesDarkness) {
  const auto source = open(text_of(lopsided)).value();
  EXPECT_EQ(value_at(*source, {91, 0}, {10, 0}), 0);
  EXPECT_EQ(value_at(*source, {10, 0}, {91, 0}), 0);
  EXPECT_GT(value_at(*source, {90, 0}, {90, 0}), 0);
  EXPECT_THAT(open(text_of([](const Centre&, const Centre&) { return 0.0; })).error().message, HasSubstr("positive"));
}

}  // namespace
}  // namespace sbrdf::internal
