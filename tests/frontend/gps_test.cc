#include <highwall/frontend/input/gps.h>

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::gps_test {
namespace {

class GpsTest : public ::testing::Test {
 protected:
  std::vector<GpsFix> Read(const std::string& text) const {
    testing::WriteText(file(), text);
    return ReadGps(file());
  }
  std::string Refusal(const std::string& text) const {
    return testing::MessageOf<IoError>([&] { Read(text); });
  }
  std::filesystem::path file() const { return folder_.path() / "gps.csv"; }

  const testing::TemporaryDirectory folder_{"gps"};
};

TEST_F(GpsTest, MetresAreTakenAsTheyAre) {
  const auto fixes = Read(
      "# stamp [s], x [m], y [m], z [m], sigma_x, sigma_y, sigma_z\n"
      "1305031102.175304123, 450000.25, -3, 7, 0.5, 0.6, 1\r\n"
      "\n"
      "1305031101 1 2 3\n");
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_EQ(fixes[0].stamp, 1305031101000000000) << "in the order of the stamps";
  EXPECT_EQ(fixes[0].sigma, Eigen::Vector3d(2.5, 2.5, 5.0));
  EXPECT_EQ(fixes[1].stamp, 1305031102175304123);
  EXPECT_EQ(fixes[1].p_G, Eigen::Vector3d(450000.25, -3, 7));
  EXPECT_EQ(fixes[1].sigma, Eigen::Vector3d(0.5, 0.6, 1));
}

TEST_F(GpsTest, DegreesBecomeMetresEastNorthAndUpOfTheFirstFix) {
  const auto fixes = Read(
      "stamp,lat,lon,alt\n"
      "1,48.0,11.0,500\n"
      "2,48.001,11.0,500\n"
      "3,48.0,11.001,500\n"
      "4,48.0,11.0,510\n");
  ASSERT_EQ(fixes.size(), 4u);
  EXPECT_LT(fixes[0].p_G.norm(), 1e-8);
  // A degree of latitude and of longitude at 48 deg, 500 m up, by the radii of curvature M = a (1 -
  // e^2) / w^3 and N = a / w, w^2 = 1 - e^2 sin^2: 111210.2 m and 74634.3 m.
  const double e2 = 6.69437999014e-3, a = 6378137.0, deg = M_PI / 180.0;
  const double w = std::sqrt(1.0 - e2 * std::pow(std::sin(48.0 * deg), 2));
  // The Earth's curvature lowers the arc by 1 mm over 111 m.
  EXPECT_NEAR(fixes[1].p_G.y(), (a * (1.0 - e2) / (w * w * w) + 500.0) * 1e-3 * deg, 1e-3);
  EXPECT_NEAR(fixes[1].p_G.x(), 0.0, 1e-8);
  EXPECT_NEAR(fixes[1].p_G.z(), 0.0, 2e-3);
  EXPECT_NEAR(fixes[2].p_G.x(), (a / w + 500.0) * std::cos(48.0 * deg) * 1e-3 * deg, 1e-3);
  EXPECT_NEAR(fixes[2].p_G.y(), 0.0, 2e-3);
  EXPECT_LT((fixes[3].p_G - Eigen::Vector3d(0, 0, 10)).norm(), 1e-8);
}

TEST_F(GpsTest, OnlyAColumnOfThatNameIsALatitude) {
  // A word that contains "lat" is not a column name.
  const auto metres = Read("# translation of the antenna, simulated\n1,48,11,500\n2,49,11,500\n");
  EXPECT_EQ(metres[1].p_G, Eigen::Vector3d(49, 11, 500));
  for (const char* heading :
       {"Stamp,Latitude,Longitude,Altitude\n", "#stamp lat[deg] lon[deg] alt\n"}) {
    const auto fixes = Read(std::string(heading) + "1,48.0,11.0,500\n2,48.0,11.0,510\n");
    EXPECT_LT((fixes[1].p_G - Eigen::Vector3d(0, 0, 10)).norm(), 1e-8) << heading;
  }
}

TEST_F(GpsTest, WithoutAPositionThereIsNoFix) {
  EXPECT_EQ(Read("1,nan,nan,nan\n2,1,2,3\n").size(), 1u);
}

TEST_F(GpsTest, NamesTheLineOfAnError) {
  EXPECT_NE(Refusal("1,1,2,3\n2,1,2\n").find("gps.csv:2: has 3 fields"), std::string::npos);
  EXPECT_NE(Refusal("1,1,2,x\n").find(":1: 'x' is not a number"), std::string::npos);
  EXPECT_NE(Refusal("1305031102175304123,1,2,3\n").find("write seconds"), std::string::npos);
  EXPECT_NE(Refusal("1,1,2,3,0,1,1\n").find("sigma that is not positive"), std::string::npos);
  EXPECT_NE(Refusal("1,1,2,3,1,1,nan\n").find("sigma that is not positive"), std::string::npos);
  EXPECT_NE(Refusal("1,1,2,3,1e-320,1,1\n").find("sigma that is not positive"), std::string::npos);
  EXPECT_NE(Refusal("lat lon alt\n1,1,2,1e300\n").find(":2: is farther away"), std::string::npos);
  EXPECT_NE(Refusal("# nothing\n").find("holds no fix"), std::string::npos);
  EXPECT_NE(Refusal("stamp lat lon alt\n1,450000,11,3\n").find("name the columns x y z"),
            std::string::npos);
  EXPECT_THROW(ReadGps(folder_.path() / "none.csv"), IoError);
}

}  // namespace
}  // namespace highwall::gps_test
