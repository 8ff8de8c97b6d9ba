#include <highwall/frontend/input/sensor_profile.h>

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::sensor_profile_test {
namespace {

TEST(SensorProfile, KnowsTheCamerasThatPeopleHave) {
  for (const char* name : {"kinect1", "kinect2", "azure", "d415", "d435", "d455", "l515", "iphone",
                           "hololens", "generic"}) {
    const SensorProfile* profile = FindSensorProfile(name);
    ASSERT_NE(profile, nullptr) << name;
    EXPECT_EQ(profile->name, name);
    EXPECT_NO_THROW(profile->SensorFor({}).Validate()) << name;
    EXPECT_NE(SensorProfileList().find(name), std::string::npos);
  }
  EXPECT_EQ(SensorProfiles().size(), 10u);
  EXPECT_EQ(FindSensorProfile("d999"), nullptr);
}

TEST(SensorProfile, TheGenericOneIsTheDefaultSensorWithMillimetres) {
  const RgbdSensor generic = FindSensorProfile("generic")->SensorFor({}), usual;
  EXPECT_EQ(generic.min_depth, 0.05);
  EXPECT_EQ(generic.max_depth, 20.0);
  EXPECT_EQ(usual.min_depth, generic.min_depth);
  EXPECT_EQ(usual.max_depth, generic.max_depth);
  EXPECT_EQ(generic.depth_noise.Sigma(3.0), usual.depth_noise.Sigma(3.0));
}

// At a given field of view the noise at a depth is proportional to the size of the pixel.
TEST(SensorProfile, StereoNoiseFollowsTheFocalLengthOfTheCamera) {
  const SensorProfile& d435 = *FindSensorProfile("d435");
  const PinholeCamera vga{.fx = 618.0, .fy = 618.0};
  const PinholeCamera hd{.width = 1280, .height = 720, .fx = 927.0, .fy = 927.0};
  const double sigma = d435.NoiseFor(vga).Sigma(2.0);
  EXPECT_NEAR(d435.NoiseFor(hd).Sigma(2.0), sigma * 618.0 / 927.0, 1e-9);
  // The stereo pair's modes with the same number of rows: 848 x 480 with 424 px, 1280 x 720 with
  // 642 px.
  EXPECT_NEAR(sigma, DepthNoise::Stereo(0.08, 424.0, 0.05).Sigma(2.0), 0.01 * sigma);
  EXPECT_NEAR(d435.NoiseFor(hd).Sigma(2.0), DepthNoise::Stereo(0.08, 642.0, 0.05).Sigma(2.0),
              0.01 * sigma);
}

// The values are those of the data sheets, to within the rounding of their figures.
TEST(SensorProfile, NoiseIsThatOfTheSources) {
  const auto sigma = [](const char* name, double z) {
    return FindSensorProfile(name)->NoiseFor({}).Sigma(z);
  };
  EXPECT_NEAR(sigma("l515", 1.0), 0.0025, 1e-4);
  EXPECT_NEAR(sigma("l515", 9.0), 0.0155, 1e-4);
  for (const double z : {0.5, 1.0, 2.0, 4.5}) {
    EXPECT_NEAR(sigma("kinect2", z), 1e-3 * (1.5 - 0.5 * z + 0.3 * z * z), 1e-5) << z;
  }
  EXPECT_NEAR(sigma("azure", 3.5), 0.017, 5e-4);
  EXPECT_DOUBLE_EQ(sigma("kinect1", 2.0), DepthNoise::Kinect().Sigma(2.0));
}

TEST(SensorProfile, NearReadingsOfAPhoneAreGoodEnoughForLandmarks) {
  const RgbdSensor phone = FindSensorProfile("iphone")->SensorFor({});
  EXPECT_LE(phone.min_depth, 0.15);
  EXPECT_LT(phone.depth_noise.Sigma(0.15), 0.03 * 0.15);
}

TEST(SensorPreset, HasTheDepthOfAKinect) {
  const SensorProfile& kinect = *FindSensorProfile("kinect1");
  for (const char* name : {"tum1", "tum2", "tum3"}) {
    const RgbdSensor sensor = SensorPreset(name).value();
    EXPECT_EQ(sensor.min_depth, kinect.min_depth);
    EXPECT_EQ(sensor.max_depth, kinect.max_depth);
    EXPECT_GE(sensor.depth_factor, 5000.0);
  }
}

}  // namespace
}  // namespace highwall::sensor_profile_test
