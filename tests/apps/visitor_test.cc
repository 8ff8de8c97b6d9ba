#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "simulate/scenes/room.h"
#include "simulate/scenes/visitor.h"

namespace highwall::simulate::visitor_test {
namespace {

constexpr double kHalfWidth = 0.21;  // [m] of the shoulders, a person's widest part

SimulationOptions SmallOptions(double duration) {
  SimulationOptions options;
  options.duration = duration;
  options.camera = {
      .width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5};
  options.sensor.noise = SensorNoise::kOff;
  options.imu.enabled = false;
  return options;
}

CameraPath PathOf(double duration, std::uint64_t seed) {
  return CameraPath(MakeRoomTrajectory(duration, seed, kLongestLapWithVisitor), 0.0);
}

// Returns points on all edges of the room's furniture up to a person's height, 5 cm apart.
std::vector<Eigen::Vector3d> FurnitureEdges(const Scene& room) {
  std::vector<Eigen::Vector3d> points;
  for (const std::array<std::uint32_t, 3>& triangle : room.mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& a = room.mesh.vertices[triangle[i]];
      const Eigen::Vector3d& b = room.mesh.vertices[triangle[(i + 1) % 3]];
      const int steps = std::max(1, static_cast<int>((b - a).norm() / 0.05));
      for (int k = 0; k <= steps; ++k) {
        const Eigen::Vector3d p = a + (b - a) * k / steps;
        if (p.z() > 0.01 && p.z() < 1.72) points.push_back(p);  // without the floor
      }
    }
  }
  return points;
}

TEST(Visitor, WalksBetweenTheFurnitureAndTheCamera) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const CameraPath path = PathOf(24.0, seed);
    const std::vector<Eigen::Vector3d> furniture = FurnitureEdges(MakeRoom(seed));
    ASSERT_GT(furniture.size(), 1000u);
    double to_furniture = 10.0, to_camera = 10.0;
    for (double t = 0.0; t < 24.0; t += 0.1) {
      const Eigen::Vector3d p_WB = VisitorAt(path, t).p();
      to_camera = std::min(to_camera, (path.T_WC(t).p() - p_WB).head<2>().norm());
      for (const Eigen::Vector3d& p : furniture) {
        to_furniture = std::min(to_furniture, (p - p_WB).head<2>().norm());
      }
    }
    EXPECT_GT(to_furniture, kHalfWidth) << seed;
    EXPECT_GT(to_camera, kHalfWidth + 0.4) << seed;  // the minimum depth of a Kinect
  }
}

TEST(Visitor, WalksForwardAndIsInViewAGoodPartOfTheTime) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const CameraPath path = PathOf(24.0, seed);
    const PinholeCamera camera;
    int seen = 0, all = 0;
    for (double t = 0.0; t < 24.0; t += 0.1, ++all) {
      const Pose T_WB = VisitorAt(path, t);
      const Eigen::Vector3d step = T_WB.Inverse() * VisitorAt(path, t + 0.01).p();
      EXPECT_LT(std::abs(step.y()), 0.02 * 0.01) << t;  // [m/s] sideways
      EXPECT_GT(step.x(), -0.2 * 0.01) << t;            // nearly stops where the camera passes by
      EXPECT_LT(step.x(), 2.2 * 0.01) << t;
      const Eigen::Vector3d chest_C =
          path.T_WC(t).Inverse() * (T_WB * Eigen::Vector3d(0.0, 0.0, 1.2));
      if (chest_C.z() <= 0.1) continue;
      const Eigen::Vector2d uv = camera.Project(chest_C);
      seen += uv.x() > 0.0 && uv.x() < camera.width && uv.y() > 0.0 && uv.y() < camera.height;
    }
    EXPECT_GT(seen, 0.3 * all) << seed;
    EXPECT_LT(seen, 0.7 * all) << seed;
  }
}

TEST(Visitor, IsNearerThanTheRoomWhereTheImageChanges) {
  SimulationOptions options = SmallOptions(10.0);
  const SimulatedFrame still = SimulateRoom(options).Render(60);
  options.traffic = true;
  const SimulatedFrame moving = SimulateRoom(options).Render(60);  // t = 2 s, right ahead
  ASSERT_EQ((still.T_WC.p() - moving.T_WC.p()).norm(), 0.0);
  const cv::Mat nearer = moving.depth<still.depth, farther = moving.depth> still.depth;
  const int pixels = still.depth.rows * still.depth.cols;
  EXPECT_EQ(cv::countNonZero(farther), 0);
  EXPECT_GT(cv::countNonZero(nearer), pixels / 20);
  EXPECT_LT(cv::countNonZero(nearer), pixels / 2);
}

}  // namespace
}  // namespace highwall::simulate::visitor_test
