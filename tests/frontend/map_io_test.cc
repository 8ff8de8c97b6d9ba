#include <highwall/frontend/map_io.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/frontend/relocalizer.h>

#include "synthetic_scene.h"

namespace highwall {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;

const Pose kPoses[] = {
    Pose::FromTangent({0, 0, 0}, {0, -0.3, 0}), Pose::FromTangent({0.2, 0, 0}, {0, -0.1, 0}),
    Pose::FromTangent({0.3, 0.1, 0}, {0, 0.1, 0}), Pose::FromTangent({0.3, 0.1, 0}, {0, 0.3, 0})};

class MapIoTest : public ::testing::Test {
 protected:
  MapIoTest() {
    for (const Pose& T_WC : kPoses) {
      scene_map.Add(Look(scene, IdealSensor(), T_WC, {.px = 0.5, .depth = true}), T_WC);
    }
    // Gaps in the ids.
    map().RemoveKeyFrame(1, 0);
    map().RemovePoint(map().point_ids()[3]);
    map().RemoveLine(map().line_ids()[2]);
    std::filesystem::remove(path);
  }
  ~MapIoTest() override { std::filesystem::remove(path); }

  Map& map() { return scene_map.map; }
  void Save() const { SaveMap(path, IdealSensor().camera, scene_map.map); }
  std::string Bytes() const {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  void Write(const std::string& bytes) const { std::ofstream(path, std::ios::binary) << bytes; }
  // One line that begins with the path and says `what`.
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

TEST_F(MapIoTest, WhatWasSavedIsLoaded) {
  Save();
  const SavedMap saved = LoadMap(path);
  EXPECT_EQ(saved.camera.fx, IdealSensor().camera.fx);
  EXPECT_EQ(saved.camera.width, IdealSensor().camera.width);
  ASSERT_EQ(saved.map.num_keyframes(), 3u);
  ASSERT_EQ(saved.map.num_points(), map().num_points());
  ASSERT_EQ(saved.map.num_lines(), map().num_lines());
  EXPECT_EQ(saved.map.index().size(), 3u);
  EXPECT_EQ(saved.map.keyframe_ids(), (std::vector<KeyFrameId>{0, 1, 2})) << "without gaps";

  const KeyFrame& old = *map().keyframe(2);
  const KeyFrame& same = *saved.map.keyframe(1);
  EXPECT_EQ(same.T_WC.Matrix(), old.T_WC.Matrix());
  EXPECT_EQ(same.frame.stamp, old.frame.stamp);
  const FrameFeatures &a = *old.frame.features, &b = *same.frame.features;
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.points[5].uv, b.points[5].uv);
  EXPECT_EQ(a.points[5].depth_sigma, b.points[5].depth_sigma);
  EXPECT_EQ(a.points[5].octave, b.points[5].octave);
  EXPECT_EQ(DescriptorRow(a.point_descriptors, 7), DescriptorRow(b.point_descriptors, 7));
  EXPECT_EQ(b.point_grid.size(), b.points.size());
  ASSERT_EQ(a.lines.size(), b.lines.size());
  EXPECT_EQ(a.lines[1].segment.e, b.lines[1].segment.e);
  ASSERT_TRUE(b.lines[1].segment_C);
  EXPECT_EQ(a.lines[1].segment_C->q_C, b.lines[1].segment_C->q_C);
  EXPECT_EQ(DescriptorRow(a.line_descriptors, 1), DescriptorRow(b.line_descriptors, 1));

  const MapPoint& point = *map().point(map().point_ids().back());
  const MapPoint& same_point = *saved.map.point(saved.map.point_ids().back());
  EXPECT_EQ(same_point.p_W, point.p_W);
  EXPECT_EQ(same_point.normal_W, point.normal_W);
  EXPECT_EQ(same_point.max_distance, point.max_distance);
  EXPECT_EQ(same_point.descriptor, point.descriptor);
  EXPECT_EQ(same_point.observations.size(), point.observations.size());
  const MapLine& line = *saved.map.line(saved.map.line_ids().back());
  EXPECT_EQ(line.segment_W.q(), map().line(map().line_ids().back())->segment_W.q());
  EXPECT_TRUE(line.has_descriptor);
}

TEST_F(MapIoTest, ACameraFindsItselfInALoadedMap) {
  Save();
  const SavedMap saved = LoadMap(path);
  const MeasurementModel model(IdealSensor(), {});
  const Pose truth = Pose::FromTangent({0.25, 0.05, 0.1}, {0.02, 0.05, 0.0});
  const auto found =
      Relocalizer(model, {}).Relocalize(*Look(scene, IdealSensor(), truth).features, saved.map);
  ASSERT_TRUE(found);
  EXPECT_LT(PositionError(found->T_WC, truth), 1e-6);  // exact features, exact landmarks
}

TEST_F(MapIoTest, SavingTwiceGivesTheSameBytes) {
  Save();
  const std::string first = Bytes();
  SaveMap(path, IdealSensor().camera, LoadMap(path).map);
  EXPECT_EQ(Bytes(), first);
}

TEST_F(MapIoTest, AnEmptyMapIsAMap) {
  SaveMap(path, IdealSensor().camera, Map());
  EXPECT_EQ(LoadMap(path).map.num_keyframes(), 0u);
}

TEST_F(MapIoTest, RefusesWhatIsMissingForeignOrCutShort) {
  ExpectError("cannot be read");
  Write("ply\nformat ascii 1.0\n");
  ExpectError("no map");
  Write("");
  ExpectError("no map");
  Save();
  const std::string bytes = Bytes();
  for (const std::size_t size :
       {std::size_t{8}, std::size_t{23}, std::size_t{24}, bytes.size() / 2, bytes.size() - 1}) {
    Write(bytes.substr(0, size));
    ExpectError("cut short");
  }
}

TEST_F(MapIoTest, RefusesAnyChangedByte) {
  Save();
  const std::string bytes = Bytes();
  for (std::size_t i = 24; i < bytes.size(); i += bytes.size() / 50) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    Write(damaged);
    ExpectError("checksum");
  }
  Write(bytes + "more");
  ExpectError("checksum");
}

TEST_F(MapIoTest, RefusesAnotherVersion) {
  Save();
  std::string bytes = Bytes();
  bytes[8] = 9;
  Write(bytes);
  ExpectError("version 9");
}

TEST_F(MapIoTest, AFailedSaveLeavesTheOldFile) {
  Save();
  const std::string bytes = Bytes();
  EXPECT_THROW(SaveMap(path / "below_a_file", IdealSensor().camera, map()), IoError);
  EXPECT_EQ(Bytes(), bytes);
}

}  // namespace
}  // namespace highwall
