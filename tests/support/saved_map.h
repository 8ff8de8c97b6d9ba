// A map of a small scene and the file it is saved in, for the tests of saving, loading and rejected
// files.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>
#include <highwall/factors/position.h>
#include <highwall/frontend/map/map.h>

#include "support/crc32.h"
#include "support/id_literals.h"
#include "support/position_in_frame.h"
#include "support/synthetic_scene.h"

namespace highwall::testing {

inline const Pose kPoses[] = {
    Pose::FromTangent({0, 0, 0}, {0, -0.3, 0}), Pose::FromTangent({0.2, 0, 0}, {0, -0.1, 0}),
    Pose::FromTangent({0.3, 0.1, 0}, {0, 0.1, 0}), Pose::FromTangent({0.3, 0.1, 0}, {0, 0.3, 0})};

// Offset of the list of submaps in a file: after the header, the camera and the kind of points,
// ORB.
inline constexpr std::size_t kKind = 4 + 3 + 1 + 4 + 4 + 8 + 4, kSubmapsAt = 24 + 40 + kKind;

class SavedMapTest : public ::testing::Test {
 protected:
  SavedMapTest() {
    for (const Pose& T_WC : kPoses) {
      scene_map.Add(Look(scene, IdealSensor(), T_WC, {.px = 0.5, .depth = true}), T_WC);
    }
    // Gaps in the ids.
    map().RemoveKeyFrame(1_kf, 0_kf);
    map().Remove(map().ids<MapPoint>()[3]);
    map().Remove(map().ids<MapLine>()[2]);
    std::filesystem::remove(path);
  }
  ~SavedMapTest() override { std::filesystem::remove(path); }

  Map& map() { return scene_map.map; }
  void Save() const { SaveMap(path, IdealSensor().camera, scene_map.map); }
  std::string Bytes() const {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  void Write(const std::string& bytes) const { std::ofstream(path, std::ios::binary) << bytes; }
  // Returns the bytes with the checksum of their content.
  static std::string WithChecksum(std::string bytes) {
    const std::uint32_t crc = Crc32(std::string_view(bytes).substr(24));
    std::memcpy(bytes.data() + 12, &crc, 4);
    return bytes;
  }
  // Returns the map with one more keyframe, whose features were edited.
  void SaveEdited(const std::function<void(FrameFeatures&)>& edit, double found = 0.0) const {
    Frame frame = scene_map.map.keyframe(0_kf)->frame;
    FrameFeatures features = *frame.features;
    edit(features);
    frame.features = std::make_shared<const FrameFeatures>(std::move(features));
    Map edited = scene_map.map.Clone();
    edited.AddKeyFrame(frame, Pose()).found = found;
    SaveMap(path, IdealSensor().camera, edited);
  }
  // Expects one line that begins with the path and contains `what`.
  void ExpectError(const std::string& what) const {
    try {
      LoadMap(path);
      FAIL() << what;
    } catch (const IoError& e) {
      const std::string message = e.what();
      EXPECT_EQ(message.find(path.string()), 0u) << message;
      EXPECT_NE(message.find(what), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }

  const Scene scene = MakeScene(5, 300, 40);
  SceneMap scene_map{scene};
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() /
      (std::string("highwall_map_io_") +
       ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

// Adds a GPS and a marker, of which only the first has a known pose, and factors: some can be
// saved, three of them cannot.
inline void AddFactors(Map& map) {
  const ReferenceFrameId gps = map.factors().AddFrame({}),
                         marker = map.factors().AddFrame({.upright = false});
  map.factors().Place(gps, kFirstSubmap, Pose::FromTangent({4e5, 5e6, 300}, {0.01, 0, 2}));
  const Pose T_KB = Pose::FromTangent({0.1, 0, 0.2}, {0, 0.3, 0});
  Eigen::Matrix3d W;
  W << 2, 0.1, 0, 0, 2, 0, 0, 0, 1;
  const auto position = std::make_shared<PositionFactor>(Eigen::Vector3d(4e5, 5e6, 301),
                                                         Eigen::Vector3d(0.1, -0.5, 0.2), W);
  map.AddFactor({{{2_kf, T_KB}}, gps, position, std::make_shared<ceres::HuberLoss>(2.7)});
  map.AddFactor({{{0_kf, T_KB}}, marker, position, nullptr});
  map.AddFactor({{{2_kf, T_KB}}, gps, position, std::make_shared<ceres::CauchyLoss>(2.7)});
  map.AddFactor({{{2_kf, T_KB}}, gps, PositionInFrame({1, 2, 3}, 0.1), nullptr});
  Eigen::Matrix<double, 6, 6> of_motion = 3.0 * Eigen::Matrix<double, 6, 6>::Identity();
  of_motion(0, 4) = 0.25;
  map.AddFactor(
      {{{0_kf, T_KB}, {2_kf, T_KB}},
       kNoId,
       std::make_shared<RelativePose>(Pose::FromTangent({0.1, 0.2, 0.3}, {0, 0.1, 0}), of_motion),
       std::make_shared<ceres::HuberLoss>(1.5)});
}

}  // namespace highwall::testing
