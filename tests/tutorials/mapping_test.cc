// The program of docs/tutorial_mapping.md.
#include "examples/mapping/survey.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <simulate/scenes/room.h>

#include "support/rendered_walk.h"
#include "support/temporary_directory.h"

namespace highwall {
namespace {

TEST(MappingTutorial, MakesTheRoomThatTheCameraSees) {
  simulate::SimulationOptions options;
  options.seed = 3;
  options.duration = 1.5;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  const std::vector<RgbdImage> images = testing::Render(simulate::SimulateRoom(options)).images;
  const RgbdSensor sensor{.camera = options.camera};

  std::size_t next = 0;
  const auto maps = Survey(sensor, [&]() -> std::optional<RgbdImage> {
    if (next == images.size()) return std::nullopt;
    return images[next++];
  });
  ASSERT_EQ(maps.size(), 1u);
  const DenseMap& map = maps.at(0);

  // The world frame is that of the first camera, so the points seen there are where the cloud is.
  // Not all of them: later images see behind objects.
  const Eigen::Matrix3d R_CW = (Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished();
  std::size_t in_view = 0, as_seen = 0, occupied = 0;
  for (const ColoredPoint& point : map.cloud) {
    const Eigen::Vector3d p_C = R_CW * point.p.cast<double>();
    occupied += map.octree.IsOccupied(point.p.cast<double>()).value_or(false);
    if (p_C.z() < 0.3) continue;
    const cv::Point pixel(
        static_cast<int>(std::lround(sensor.camera.fx * p_C.x() / p_C.z() + sensor.camera.cx)),
        static_cast<int>(std::lround(sensor.camera.fy * p_C.y() / p_C.z() + sensor.camera.cy)));
    if (!cv::Rect(cv::Point(), images[0].depth.size()).contains(pixel)) continue;
    const float depth = images[0].depth.at<float>(pixel);
    if (depth == 0.0f) continue;
    ++in_view;
    as_seen += std::abs(depth - p_C.z()) < 0.1;
  }
  ASSERT_GT(in_view, 1000u);
  EXPECT_GT(static_cast<double>(as_seen), 0.9 * static_cast<double>(in_view));
  EXPECT_GT(static_cast<double>(occupied), 0.9 * static_cast<double>(map.cloud.size()));
  EXPECT_GT(map.grid.width, 0);

  const testing::TemporaryDirectory folder("survey");
  WriteSurvey(maps, folder.path());
  for (const char* file : {"cloud_0.ply", "map_0.bt", "grid_0.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;
  }
}

}  // namespace
}  // namespace highwall
