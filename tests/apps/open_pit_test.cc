#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "simulate/camera/raycaster.h"
#include "simulate/scenes/haul_road.h"
#include "simulate/scenes/mine.h"

namespace highwall::simulate::open_pit_test {
namespace {

// Building a scene takes most of a second, and every test runs alone: few tests check many things.
class OpenPit : public ::testing::TestWithParam<std::string> {
 protected:
  static Simulation Simulate(const SimulationOptions& options) {
    return GetParam() == "mine" ? SimulateMine(options) : SimulateRoad(options);
  }
  // Returns the largest rotational blur within half a second about t, with the exposure of the
  // image at t [px of 640 x 480].
  static double LongestBlur(const Simulation& simulation, double t) {
    const Stamp middle = simulation.StampOf(0) + FromSeconds(t);
    const double exposure =
        simulation.Render(static_cast<int>(t * simulation.options().fps)).exposure.time;
    double fastest = 0.0;  // [rad/s]
    for (int k = -25; k < 25; ++k) {
      const Stamp begin = middle + k * 10'000'000;
      const Pose turn = simulation.T_WC(begin).Inverse() * simulation.T_WC(begin + 2'000'000);
      fastest = std::max(fastest, turn.Angle() / 0.002);
    }
    return 615.0 * fastest * exposure;
  }
  static double Lap() { return GetParam() == "mine" ? 84.0 : 76.0; }  // [s] approximate
};

TEST_P(OpenPit, DriveIsSteadyAndKeepsClear) {
  SimulationOptions options = FieldTestOptions();
  options.duration = Lap() + 5.0;
  options.imu.ideal = true;
  const Simulation simulation = Simulate(options);
  const auto at = [&](double t) { return simulation.T_WC(simulation.StampOf(0) + FromSeconds(t)); };
  EXPECT_EQ((at(0.0).p() - at(1.0).p()).norm(), 0.0);  // it starts from rest

  const Raycaster raycaster(simulation.scene().mesh);
  for (double t = 2.0; t < options.duration; t += 0.1) {
    const Pose here = at(t);
    // Averaged over a second, because bumps swing the camera back and forth.
    EXPECT_NEAR((at(t + 1.0).p() - here.p()).head<2>().norm(), 0.6, 0.2) << t;
    // The ground is about 0.8 m below, and there is no obstacle within 0.4 m.
    EXPECT_FALSE(raycaster.IsFree(here.p(), -Eigen::Vector3d::UnitZ(), 1.0)) << t;
    EXPECT_TRUE(raycaster.IsFree(here.p(), -Eigen::Vector3d::UnitZ(), 0.65)) << t;
    for (int k = 0; k < 100; ++k) {
      const double z = 1.0 - (2.0 * k + 1.0) / 100, r = std::sqrt(1.0 - z * z);
      const double azimuth = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
      EXPECT_TRUE(
          raycaster.IsFree(here.p(), {r * std::cos(azimuth), r * std::sin(azimuth), z}, 0.4))
          << t;
    }
  }
  // The IMU measures the bumps.
  const auto roughness = [&](double begin, double end) {
    double sum = 0.0;
    int count = 0;
    for (double t = begin; t < end; t += 0.02, ++count) {
      const TrueState a = simulation.StateAt(simulation.StampOf(0) + FromSeconds(t));
      const TrueState b = simulation.StateAt(simulation.StampOf(0) + FromSeconds(t + 0.02));
      sum += (b.state.v_WB - a.state.v_WB).squaredNorm() / (0.02 * 0.02);
    }
    return std::sqrt(sum / count);
  };
  const Stretch& bumpy = simulation.stretches().front();
  ASSERT_EQ(bumpy.kind, StretchKind::kBumpy);
  EXPECT_GT(roughness(bumpy.begin + 0.5, bumpy.end - 0.5), 2.0 * roughness(2.0, bumpy.begin));
  for (const Stretch& stretch : simulation.stretches()) EXPECT_LE(stretch.end, options.duration);
  if (GetParam() == "mine") return;
  const std::vector<Stretch> listed = RoadStretches(options);
  ASSERT_EQ(listed.size(), simulation.stretches().size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    EXPECT_EQ(listed[i].kind, simulation.stretches()[i].kind) << i;
    EXPECT_EQ(listed[i].begin, simulation.stretches()[i].begin) << i;
    EXPECT_EQ(listed[i].end, simulation.stretches()[i].end) << i;
  }
}

TEST_P(OpenPit, SameSeedSameBytesWhateverTheThreads) {
  SimulationOptions options = FieldTestOptions();
  options.camera = {
      .width = 160, .height = 120, .fx = 153.75, .fy = 153.75, .cx = 79.5, .cy = 59.5};
  options.imu.enabled = false;
  const SimulatedFrame one = Simulate(options).Render(100, 1),
                       four = Simulate(options).Render(100, 4);
  EXPECT_EQ(std::memcmp(one.bgr.data, four.bgr.data, one.bgr.total() * 3), 0);
  EXPECT_EQ(std::memcmp(one.depth.data, four.depth.data, one.depth.total() * 4), 0);
  options.seed = 2;
  const SimulatedFrame other = Simulate(options).Render(100);
  EXPECT_GT(cv::norm(one.bgr, other.bgr, cv::NORM_L1) / (160 * 120 * 3), 5.0);
}

TEST_P(OpenPit, IsRichInFeaturesExceptUnderDust) {
  SimulationOptions options = FieldTestOptions();
  options.duration = Lap();
  options.imu.enabled = false;
  options.camera = {
      .width = 320, .height = 240, .fx = 307.5, .fy = 307.5, .cx = 159.5, .cy = 119.5};
  const Simulation simulation = Simulate(options);
  const auto orb = cv::ORB::create(3000);
  const auto lsd = cv::createLineSegmentDetector();
  struct Count {
    std::size_t corners = 0;
    std::ptrdiff_t segments = 0;
  };
  const auto count = [&](double t) {
    cv::Mat grey;
    cv::cvtColor(simulation.Render(static_cast<int>(t * options.fps)).bgr, grey,
                 cv::COLOR_BGR2GRAY);
    std::vector<cv::KeyPoint> corners;
    orb->detect(grey, corners);
    std::vector<cv::Vec4f> segments;
    lsd->detect(grey, segments);
    const auto is_long = [](const cv::Vec4f& s) {
      return std::hypot(s[0] - s[2], s[1] - s[3]) > 20.0f;
    };
    return Count{corners.size(), std::count_if(segments.begin(), segments.end(), is_long)};
  };
  for (const double t : {2.0, 5.0, 8.0}) {
    const Count rich = count(t);
    EXPECT_GE(rich.corners, 600u) << t;
    EXPECT_GE(rich.segments, 10) << t;
  }
  const auto middle_of = [&simulation](StretchKind kind) {
    const auto found = std::find_if(simulation.stretches().begin(), simulation.stretches().end(),
                                    [kind](const Stretch& s) { return s.kind == kind; });
    return found == simulation.stretches().end() ? 0.0 : 0.5 * (found->begin + found->end);
  };
  EXPECT_LE(count(middle_of(StretchKind::kLowTexture)).corners, count(5.0).corners / 3);
  EXPECT_GT(LongestBlur(simulation, middle_of(StretchKind::kBlurred)), 4.0);
  EXPECT_LT(LongestBlur(simulation, 5.0), 1.5);
}

INSTANTIATE_TEST_SUITE_P(Scenes, OpenPit, ::testing::Values("road", "mine"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace highwall::simulate::open_pit_test
