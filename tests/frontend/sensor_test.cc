#include <highwall/frontend/input/sensor.h>

#include <cmath>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::sensor_test {
namespace {

TEST(SensorPreset, KnowsTheThreeSensorsOfTumRgbd) {
  EXPECT_EQ(SensorPresetNames(), (std::vector<std::string_view>{"tum1", "tum2", "tum3"}));
  for (const std::string_view name : SensorPresetNames()) {
    ASSERT_TRUE(SensorPreset(name));
    EXPECT_NO_THROW(SensorPreset(name)->Validate());
  }
  EXPECT_EQ(SensorPreset("tum1")->camera.p2, 0.0026);
  EXPECT_EQ(SensorPreset("tum2")->depth_factor, 5208.0);
  EXPECT_EQ(SensorPreset("tum3")->camera.fy, 539.2);
  EXPECT_FALSE(SensorPreset("tum3")->camera.HasDistortion());
  EXPECT_FALSE(SensorPreset("tum4"));
}

TEST(RgbdSensor, RefusesADepthFactorThatIsNotPositive) {
  for (const double factor : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(RgbdSensor{.depth_factor = factor}.Validate(), InvalidArgument);
  }
}

TEST(RgbdSensor, RefusesARangeThatHoldsNothing) {
  for (const double min : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(RgbdSensor{.min_depth = min}.Validate(), InvalidArgument);
  }
  for (const double max : {0.05, -1.0, std::nan("")}) {
    EXPECT_THROW(RgbdSensor{.max_depth = max}.Validate(), InvalidArgument);
  }
}

}  // namespace
}  // namespace highwall::sensor_test
