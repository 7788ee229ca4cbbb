#include "converters/files/zemax/zemax_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/vec3.hpp>
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

/// A file to be written down: f_r of rotation, incidence, azimuth and radial [degrees].
struct Written {
  std::string symmetry = "Asymmetrical4D";
  std::string spectrum = "Monochrome";
  std::string scatter = "BRDF";
  std::string tis = "0.5";
  std::vector<double> rotations = {0, 90, 180, 270};
  std::vector<double> incidences = {0, 20, 50, 80};
  std::vector<double> azimuths = {0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330};
  std::vector<double> radials = {0, 5, 15, 30, 60, 90, 120, 150, 180};
  std::function<double(double, double, double, double)> value = [](double, double, double, double) { return 0.25; };
};

std::string list_text(const char* name, const std::vector<double>& angles) {
  std::string text = std::string(name) + " " + std::to_string(angles.size()) + "\n";
  for (const double angle : angles) text += std::to_string(angle) + " ";
  return text + "\n";
}

std::string text_of(const Written& file) {
  std::string text = "Source Measured\nSymmetry " + file.symmetry + "\nSpectralContent " + file.spectrum +
                     "\nScatterType " + file.scatter + "\n" + list_text("SampleRotation", file.rotations) +
                     list_text("AngleOfIncidence", file.incidences) + list_text("ScatterAzimuth", file.azimuths) +
                     list_text("ScatterRadial", file.radials);
  const bool xyz = file.spectrum == "XYZ";
  for (std::size_t c = 0; c < (xyz ? 3 : 1); ++c) {
    text += (xyz ? std::string("Tristimulus") + "XYZ"[c] : "Monochrome") + "\nDataBegin\n";
    for (const double rotation : file.rotations) {
      for (const double incidence : file.incidences) {
        text += "TIS " + file.tis + "\n";
        for (const double azimuth : file.azimuths) {
          for (const double radial : file.radials) {
            char number[40];
            const double value = file.value(rotation, incidence, azimuth, radial);
            std::snprintf(number, sizeof number, "%.9e ", value * static_cast<double>(c + 1));
            text += number;
          }
          text += "\n";
        }
      }
    }
    text += "DataEnd\n";
  }
  return text;
}

Result<std::unique_ptr<BrdfSource>> open(const Written& file, const Options& options = {}) {
  return open_source(std::make_shared<OwnedMemorySource>(small_files::bytes_of(text_of(file))), options);
}

/// As the format's page says it, with nothing of the tables' code: a direction around +z, tilted in the plane of
/// incidence until +z is the mirror direction, then turned to the light's azimuth. The light is at +x before that.
DirectionPair pair_at(double phi_i, double theta_i, double azimuth, double radial) {
  const auto rad = [](double deg) { return deg * std::numbers::pi / 180; };
  const double x = std::sin(rad(radial)) * std::cos(rad(azimuth));
  const double y = std::sin(rad(radial)) * std::sin(rad(azimuth));
  const double z = std::cos(rad(radial));
  const double tilt = rad(theta_i);
  const double x1 = std::cos(tilt) * x - std::sin(tilt) * z;
  const double z1 = std::sin(tilt) * x + std::cos(tilt) * z;
  const double turn = rad(phi_i);
  const double x2 = std::cos(turn) * x1 - std::sin(turn) * y;
  const double y2 = std::sin(turn) * x1 + std::cos(turn) * y;
  return {{tilt, turn}, {std::atan2(std::hypot(x2, y2), z1), std::atan2(y2, x2)}};
}

float value_at(const BrdfSource& source, const DirectionPair& pair, std::size_t channel = 0) {
  std::vector<float> values(source.channel_count());
  source.evaluate(std::span(&pair, 1), values);
  return values[channel];
}

bool is_measured(const BrdfSource& source, const DirectionPair& pair) {
  std::uint8_t flag = 0;
  source.measured(std::span(&pair, 1), std::span(&flag, 1));
  return flag == 1;
}

std::uint64_t count_of(const BrdfSource& source, const std::string& what) {
  for (const Finding& finding : source.traits().findings) {
    if (finding.what.find(what) != std::string::npos) return finding.count;
  }
  return 0;
}

double smooth(double rotation, double incidence, double azimuth, double radial) {
  const auto rad = [](double deg) { return deg * std::numbers::pi / 180; };
  return 0.2 + 0.05 * std::cos(rad(radial)) + 0.02 * std::sin(rad(radial)) * std::sin(rad(azimuth)) +
         0.03 * std::cos(rad(rotation) - 0.3) + 0.01 * incidence / 90;
}

constexpr double kAbove = 89.999;  // degrees, clear of the horizon

TEST(ZemaxSource, GivesTheClosedFormBackAtItsNodes) {
  Written file;
  file.value = smooth;
  const auto source = open(file);
  ASSERT_TRUE(source.ok()) << source.error().message;
  std::size_t checked = 0;
  for (const double rotation : file.rotations) {
    for (const double incidence : {20.0, 50.0, 80.0}) {
      for (const double azimuth : file.azimuths) {
        for (const double radial : file.radials) {
          const DirectionPair pair = pair_at(rotation, incidence, azimuth, radial);
          if (degrees_from_radians(pair.v.theta) > kAbove || radial == 0) continue;
          const double expected = smooth(rotation, incidence, azimuth, radial);
          ASSERT_NEAR(value_at(**source, pair), expected, 1e-6 * expected) << azimuth << " " << radial;
          ++checked;
        }
      }
    }
  }
  EXPECT_GT(checked, 500U);
  EXPECT_FALSE((*source)->traits().isotropic);
  EXPECT_FALSE((*source)->traits().reciprocal);
  EXPECT_EQ((*source)->traits().theta_max_deg, 80);
}

TEST(ZemaxSource, IsLinearBetweenNodes) {
  Written file;
  file.value = [](double, double incidence, double, double radial) { return 0.1 + radial / 1000 + incidence / 500; };
  const auto source = open(file).value();
  for (const double radial : {2.0, 22.0, 40.0, 75.0}) {
    const double expected = 0.1 + radial / 1000 + 35.0 / 500;
    EXPECT_NEAR(value_at(*source, pair_at(33, 35, 41, radial)), expected, 1e-6) << radial;
  }
}

TEST(ZemaxSource, ASampleThatTurnsIsALightThatTurnsTheOtherWay) {
  Written file;
  file.value = smooth;
  const auto light = open(file).value();
  const auto sample = open(file, Options().set("zemax-rotation", "sample")).value();
  for (const double rotation : {0.0, 37.0, 90.0, 200.0}) {
    const DirectionPair turned = pair_at(-rotation, 50, 30, 15);
    EXPECT_NEAR(value_at(*sample, turned), value_at(*light, pair_at(rotation, 50, 30, 15)), 1e-6);
  }
}

TEST(ZemaxSource, PlaneSymmetricalTablesAreMirroredAndOneRotationIsIsotropic) {
  Written file{.symmetry = "PlaneSymmetrical", .rotations = {0}, .azimuths = {0, 45, 90, 180}};
  file.value = [](double, double, double azimuth, double) { return 0.1 + azimuth / 1000; };
  const auto source = open(file).value();
  EXPECT_TRUE(source->traits().isotropic);
  for (const double azimuth : {0.0, 20.0, 100.0, 179.0}) {
    for (const double side : {1.0, -1.0}) {
      const DirectionPair pair = pair_at(123, 50, side * azimuth, 15);
      EXPECT_NEAR(value_at(*source, pair), 0.1 + azimuth / 1000, 1e-6) << azimuth;
    }
  }
}

TEST(ZemaxSource, TristimulusValuesBecomeLinearSrgb) {
  const auto source = open({.spectrum = "XYZ"}).value();  // X, Y, Z = 0.25, 0.5, 0.75
  const DirectionPair pair = pair_at(0, 50, 30, 15);
  EXPECT_NEAR(value_at(*source, pair, 0), 3.2406 * 0.25 - 1.5372 * 0.5 - 0.4986 * 0.75, 1e-6);
  EXPECT_NEAR(value_at(*source, pair, 1), -0.9689 * 0.25 + 1.8758 * 0.5 + 0.0415 * 0.75, 1e-6);
  EXPECT_NEAR(value_at(*source, pair, 2), 0.0557 * 0.25 - 0.2040 * 0.5 + 1.0570 * 0.75, 1e-6);
  EXPECT_EQ(source->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_GT(count_of(*source, "negative channel"), 0U);  // the red one is
  const auto clamped = open({.spectrum = "XYZ"}, Options().set("negatives", "clamp")).value();
  EXPECT_EQ(value_at(*clamped, pair, 0), 0);
}

Written with_gap(double elsewhere) {
  Written file;
  file.value = [elsewhere](double, double, double azimuth, double radial) {
    return azimuth == 90 && radial == 30 ? 0 : radial > 5 && azimuth < 60 ? elsewhere : 0.25;
  };
  return file;
}

TEST(ZemaxZeros, AreGapsInFilesThatAreNowhereDarkElseBlack) {
  const DirectionPair gap = pair_at(90, 50, 90, 30);
  const auto bright = open(with_gap(0.001)).value();
  EXPECT_FALSE(is_measured(*bright, gap));
  EXPECT_EQ(count_of(*bright, "exactly 0, taken as unmeasured"), 16U);
  EXPECT_TRUE(bright->mask_grid().has_value());
  const auto dark = open(with_gap(0.0001)).value();
  EXPECT_TRUE(is_measured(*dark, gap));
  EXPECT_EQ(value_at(*dark, gap), 0);
  EXPECT_EQ(count_of(*dark, "exactly 0, taken as black"), 16U);
  EXPECT_FALSE(dark->mask_grid().has_value());
}

TEST(ZemaxZeros, AreWhatAnOptionSays) {
  const DirectionPair gap = pair_at(90, 50, 90, 30);
  const auto black = open(with_gap(0.25), Options().set("zemax-zeros", "black")).value();
  EXPECT_TRUE(is_measured(*black, gap));
  EXPECT_EQ(value_at(*black, gap), 0);
  const auto unmeasured = open(with_gap(0.0001), Options().set("zemax-zeros", "unmeasured")).value();
  EXPECT_FALSE(is_measured(*unmeasured, gap));
}

TEST(ZemaxZeros, BelowTheHorizonDarkenNothingAboveIt) {
  Written file;
  file.value = [](double rotation, double incidence, double azimuth, double radial) {
    const DirectionPair pair = pair_at(rotation, incidence, azimuth, radial);
    return degrees_from_radians(pair.v.theta) > 90 + 1e-6 ? 0 : 0.25;
  };
  for (const char* zeros : {"auto", "black"}) {
    const auto source = open(file, Options().set("zemax-zeros", zeros)).value();
    EXPECT_NEAR(value_at(*source, pair_at(10, 50, 175, 38)), 0.25, 1e-6);
    EXPECT_EQ(count_of(*source, "exactly 0"), 0U);
  }
}

TEST(ZemaxFindings, TellOfSeamsAndUseTheFirst) {
  Written file{.rotations = {0, 90, 180, 270, 360}};
  file.value = [](double rotation, double, double azimuth, double) {
    return rotation == 360 ? (azimuth == 30 ? 0.75 : 0.25) : 0.25;
  };
  const auto source = open(file).value();
  EXPECT_EQ(count_of(*source, "values at SampleRotation 360 that differ from those at 0, by up to 0.5 1/sr"), 36U);
  EXPECT_NEAR(value_at(*source, pair_at(0, 50, 30, 15)), 0.25, 1e-6);
  EXPECT_EQ(source->traits().shape[0], 4U);
  file.value = [](double, double, double azimuth, double) { return azimuth == 360 ? 0.5 : 0.25; };
  file.azimuths = {0, 90, 180, 270, 360};
  EXPECT_EQ(count_of(*open(file).value(), "values at ScatterAzimuth 360 that differ"), 5U * 4 * 9);
}

TEST(ZemaxFindings, TellWhatAFileDoesNotCover) {
  const auto source = open({.rotations = {0, 30, 60, 90}, .incidences = {10, 40}, .radials = {5, 20, 60}}).value();
  EXPECT_EQ(count_of(*source, "degrees of phi_i without a SampleRotation"), 270U);
  EXPECT_EQ(count_of(*source, "degrees of theta_i below the first"), 10U);
  EXPECT_EQ(count_of(*source, "degrees of radial before the first"), 5U);
  EXPECT_EQ(count_of(*source, "degrees of radial beyond the last"), 120U);
  EXPECT_TRUE(is_measured(*source, pair_at(0, 40, 0, 60)));
  EXPECT_FALSE(is_measured(*source, pair_at(0, 40, 0, 110)));
  EXPECT_EQ(source->traits().theta_max_deg, 40);
}

TEST(ZemaxFindings, CompareTheIntegralWithTheTisStated) {
  Written file{.tis = "1"};
  file.azimuths.push_back(360);
  file.value = [](double, double, double, double) { return 1 / std::numbers::pi; };
  const auto source = open(file).value();
  EXPECT_THAT(source->traits().description, HasSubstr("integrate to 1 to 1 times the TIS"));
  EXPECT_EQ(count_of(*source, "more than 5 % from the TIS"), 0U);
  file.tis = "0.8";
  const auto other = open(file).value();
  EXPECT_EQ(
      count_of(*other,
               "from the TIS stated (1.25 to 1.25 times it; that of f_r is 2.5 to 2.5 times it), which is not used"),
      16U);
  EXPECT_NEAR(value_at(*other, pair_at(0, 50, 30, 15)), 1 / std::numbers::pi, 1e-6);
  Written half{
      .symmetry = "PlaneSymmetrical", .tis = "1", .rotations = {0}, .azimuths = {0, 90, 180}, .value = file.value};
  EXPECT_THAT(open(half).value()->traits().description, HasSubstr("integrate to 1 to 1 times"));
}

TEST(ZemaxSource, RefusesTransmissionAndDarkness) {
  const auto transmission = open({.scatter = "BTDF"});
  EXPECT_EQ(transmission.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(transmission.error().message, HasSubstr("BTDF"));
  Written dark;
  dark.value = [](double, double, double, double) { return 0; };
  EXPECT_THAT(open(dark).error().message, HasSubstr("positive"));
}

TEST(ZemaxSource, RefusesEachTruncationOfAFile) {
  const std::string text = small_files::zemax_text();
  for (std::size_t size = 1; size + 2 < text.size(); ++size) {
    EXPECT_FALSE(open_source(std::make_shared<OwnedMemorySource>(small_files::bytes_of(text.substr(0, size)))).ok())
        << size;
  }
}

}  // namespace
}  // namespace sbrdf::internal
