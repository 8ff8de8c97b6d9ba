#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "support/saved_map.h"

namespace highwall::map_io_damage_test {
namespace {

using testing::AddFactors;
using testing::IdealSensor;
using testing::kPoses;
using testing::kSubmapsAt;
using testing::operator""_kf;

using MapIoDamageTest = testing::SavedMapTest;

TEST_F(MapIoDamageTest, RefusesDepthThatNoImageHas) {
  const cv::Mat depth(60, 80, CV_32FC1, cv::Scalar(1.0));
  ASSERT_EQ(DepthGrid(IdealSensor().camera).camera().height, depth.rows);
  SaveEdited([&](FrameFeatures& features) { features.depth_grid = depth.t(); });
  EXPECT_NO_THROW(LoadMap(path)) << "as many cells";
  SaveEdited([&](FrameFeatures& features) { features.depth_grid = depth.rowRange(0, 59); });
  ExpectError("its depth is not that of its camera");
  for (const float none : {-1.0F, std::numeric_limits<float>::quiet_NaN()}) {
    cv::Mat wrong = depth.clone();
    wrong.at<float>(5, 5) = none;
    SaveEdited([&](FrameFeatures& features) { features.depth_grid = wrong; });
    ExpectError("a depth is none");
  }
  SaveEdited([](FrameFeatures&) {}, -0.5);
  ExpectError("found less than nothing");
}

// A keyframe with a submap that is not in the list.

TEST_F(MapIoDamageTest, RefusesAKeyFrameOfNoSubmap) {
  Save();
  const std::string bytes = Bytes();
  for (const std::int32_t submap : {1, -1, std::numeric_limits<std::int32_t>::max()}) {
    std::string damaged = bytes;
    std::memcpy(damaged.data() + kSubmapsAt + (4 + 5) + 4, &submap, 4);  // of the first
    Write(WithChecksum(damaged));
    ExpectError("a keyframe is of no submap");
  }
}

TEST_F(MapIoDamageTest, RefusesASubmapThatIsJoinedWithNone) {
  map().AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[1], map().AddSubmap());
  Save();
  std::string bytes = Bytes();
  const std::int32_t root = 2;
  std::memcpy(bytes.data() + kSubmapsAt + 4 + 5, &root, 4);  // of the second
  Write(WithChecksum(bytes));
  ExpectError("a submap is joined with none");
}

TEST_F(MapIoDamageTest, RefusesASubmapThatIsJoinedWithOneWithoutKeyFrames) {
  Map two;
  two.AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[0]);
  two.AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[1], two.AddSubmap());
  SaveMap(path, IdealSensor().camera, two);
  std::string bytes = Bytes();
  const std::int32_t root = 0, submap = 1;
  std::memcpy(bytes.data() + kSubmapsAt + 4 + 5, &root, 4);              // of the second submap
  std::memcpy(bytes.data() + kSubmapsAt + (4 + 2 * 5) + 4, &submap, 4);  // of the first keyframe
  Write(WithChecksum(bytes));
  ExpectError("a submap is joined with one that has no keyframe");
}

TEST_F(MapIoDamageTest, RefusesMissingForeignAndTruncatedFiles) {
  ExpectError("cannot be read");
  std::filesystem::create_directory(path);
  ExpectError("is a folder, not a map");
  std::filesystem::remove(path);
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

TEST_F(MapIoDamageTest, RefusesAnyChangedByte) {
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

TEST_F(MapIoDamageTest, RefusesAYesOrNoThatIsNeither) {
  Save();
  const std::string bytes = Bytes();
  // The first line of the first keyframe: docs/map_file.md.
  const std::size_t points = map().keyframe(0_kf)->frame.features->points.size();
  const std::size_t line =
      kSubmapsAt + (4 + 5) + 4 + (4 + 72) + (4 + 40 * points) + (4 + 32 * points) + 4;
  for (const std::size_t place : {line + 16, line + 16 + 1 + 6 * 8 + 4 * 8}) {
    ASSERT_LE(bytes[place], 1);
    std::string damaged = bytes;
    damaged[place] = 2;
    Write(WithChecksum(damaged));
    ExpectError("neither");
  }
}

TEST_F(MapIoDamageTest, RefusesFeaturesThatNoImageHas) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(map().keyframe(0_kf)->frame.features->lines[0].segment_C);
  using Edit = std::function<void(FrameFeatures&)>;
  const std::vector<std::pair<const char*, Edit>> cases = {
      {"nowhere in its image", [](FrameFeatures& f) { f.points[0].uv.x() = kNan; }},
      {"nowhere in its image", [](FrameFeatures& f) { f.points[0].uv.y() = 1e200; }},
      {"depth or its sigma", [](FrameFeatures& f) { f.points[0].depth = -1.0; }},
      {"depth or its sigma", [](FrameFeatures& f) { f.points[0].depth = kInf; }},
      {"depth or its sigma", [](FrameFeatures& f) { f.points[0].depth_sigma = kInf; }},
      {"depth or its sigma", [](FrameFeatures& f) { f.points[0].depth_sigma = 0.0; }},
      {"pyramid level", [](FrameFeatures& f) { f.points[0].octave = -1; }},
      {"pyramid level", [](FrameFeatures& f) { f.points[0].octave = 100000; }},
      {"no angle", [](FrameFeatures& f) { f.points[0].angle = -1.0F / 0.0F; }},
      {"ends in its image", [](FrameFeatures& f) { f.lines[0].segment.s = f.lines[0].segment.e; }},
      {"ends in its image", [](FrameFeatures& f) { f.lines[0].segment.s.x() = 1e30F; }},
      {"in front of its camera", [](FrameFeatures& f) { f.lines[0].segment_C->p_C.z() = 0.0; }},
      {"in front of its camera", [](FrameFeatures& f) { f.lines[0].segment_C->q_C.x() = kNan; }},
      {"as good as any", [](FrameFeatures& f) { f.lines[0].segment_C->sigma_q = kInf; }},
      {"as good as any", [](FrameFeatures& f) { f.lines[0].segment_C->inlier_share = 1.5; }},
      {"one descriptor", [](FrameFeatures& f) { f.line_descriptors.pop_back(); }},
      {"noise is none", [](FrameFeatures& f) { f.points[0].noise.px = 0.0F; }},
      {"noise is none", [](FrameFeatures& f) { f.lines[0].noise.depth = -1.0F / 0.0F; }},
  };
  SaveEdited([](FrameFeatures&) {});
  EXPECT_NO_THROW(LoadMap(path));
  for (const auto& [what, edit] : cases) {
    SaveEdited(edit);
    ExpectError(what);
  }
}

TEST_F(MapIoDamageTest, RefusesLandmarksThatNoMapHas) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const PointId point = map().ids<MapPoint>()[0];
  const LineId line = map().ids<MapLine>()[0];
  using Edit = std::function<void(Map&)>;
  const std::vector<std::pair<const char*, Edit>> cases = {
      {"is nowhere", [&](Map& m) { m.Find(point)->p_W.x() = kInf; }},
      {"from nowhere", [&](Map& m) { m.Find(point)->normal_W.z() = 7.0; }},
      {"no distance", [&](Map& m) { m.Find(point)->max_distance = kInf; }},
      {"no distance", [&](Map& m) { m.Find(point)->min_distance = -1.0; }},
      {"not counted", [&](Map& m) { m.Find(point)->visible = 0; }},
      {"not counted", [&](Map& m) { m.Find(line)->found = std::numeric_limits<int>::max(); }},
      {"beyond all",
       [&](Map& m) { m.Find(line)->first_frame = std::numeric_limits<std::int64_t>::min(); }},
      {"ends are one", [&](Map& m) { m.Find(line)->segment_W = Segment3(); }},
      {"a keyframe's pose", [&](Map& m) { m.keyframe(0_kf)->T_WC.data()[1] = kInf; }},
      {"a keyframe's pose", [&](Map& m) { m.keyframe(0_kf)->T_WC.data()[6] = 1e300; }},
      {"time is beyond all",
       [&](Map& m) { m.keyframe(0_kf)->frame.stamp = std::numeric_limits<Stamp>::max(); }},
  };
  for (const auto& [what, edit] : cases) {
    Map edited = map().Clone();
    edit(edited);
    SaveMap(path, IdealSensor().camera, edited);
    ExpectError(what);
  }
}

TEST_F(MapIoDamageTest, RefusesACameraThatNoneIs) {
  for (const auto& edit : std::vector<std::function<void(PinholeCamera&)>>{
           [](PinholeCamera& c) { c.width = 0; }, [](PinholeCamera& c) { c.height = 2000000000; },
           [](PinholeCamera& c) { c.fx = -1.0; }, [](PinholeCamera& c) { c.fy = 1e300; },
           [](PinholeCamera& c) { c.fy = 0.5 * c.fx; }, [](PinholeCamera& c) { c.cx = -1.0; },
           [](PinholeCamera& c) { c.cx = std::numeric_limits<double>::quiet_NaN(); }}) {
    PinholeCamera camera = IdealSensor().camera;
    edit(camera);
    SaveMap(path, camera, map());
    ExpectError("is damaged");
  }
}

TEST_F(MapIoDamageTest, RefusesFactorsThatNoMapHas) {
  AddFactors(map());
  Save();
  const std::string bytes = Bytes();
  constexpr std::size_t kFactor = 4 + 56 + 4 + 15 * 8 + 8;  // keyframe, pose, frame, cost, loss
  constexpr std::size_t kMotion =
      2 * (4 + 56) + 56 + 36 * 8 + 8;  // keyframes and poses, cost, loss
  const std::size_t motion = bytes.size() - kMotion;
  const std::size_t second = motion - 4 - kFactor, first = second - kFactor;
  const auto with = [&](std::size_t at, auto value) {
    std::string edited = bytes;
    std::memcpy(edited.data() + at, &value, sizeof(value));
    Write(WithChecksum(edited));
  };
  with(first, std::int32_t{7});
  ExpectError("a factor has no keyframe as its anchor");
  with(first + 4, 1e300);
  ExpectError("a factor's pose is none");
  with(second + 60, std::int32_t{2});
  ExpectError("a factor is measured in no frame");
  with(second + 64, std::numeric_limits<double>::quiet_NaN());
  ExpectError("a factor's numbers are beyond all");
  with(second + kFactor - 8, -1.0);
  ExpectError("a factor's numbers are beyond all");
  with(motion + 60, std::int32_t{7});
  ExpectError("a factor has no keyframe as its anchor");
  with(motion + 120, 1e300);
  ExpectError("a factor's motion is none");
  with(motion + 176, std::numeric_limits<double>::infinity());
  ExpectError("a factor's numbers are beyond all");
  const std::size_t frames = first - 4 - (1 + 4) - (1 + 4 + 4 + 56);  // behind their count
  with(frames + 5, std::int32_t{1});
  ExpectError("a frame lies in no world of it");
  with(frames + 9, std::numeric_limits<double>::infinity());
  ExpectError("a frame lies nowhere");
}

TEST_F(MapIoDamageTest, RefusesAnotherVersion) {
  Save();
  std::string bytes = Bytes();
  bytes[8] = 9;
  Write(bytes);
  ExpectError("version 9");
}

}  // namespace
}  // namespace highwall::map_io_damage_test
