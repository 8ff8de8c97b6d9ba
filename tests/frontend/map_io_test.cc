#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "support/saved_map.h"
#include "tracking/relocalizer.h"

namespace highwall::map_io_test {
namespace {

using testing::AddFactors;
using testing::IdealSensor;
using testing::kKind;
using testing::kPoses;
using testing::Look;
using testing::PositionError;
using testing::operator""_kf;

using MapIoTest = testing::SavedMapTest;

TEST_F(MapIoTest, LoadsTheSavedMap) {
  Save();
  const SavedMap saved = LoadMap(path);
  EXPECT_EQ(saved.camera.fx, IdealSensor().camera.fx);
  EXPECT_EQ(saved.camera.width, IdealSensor().camera.width);
  ASSERT_EQ(saved.map.num_keyframes(), 3u);
  ASSERT_EQ(saved.map.num<MapPoint>(), map().num<MapPoint>());
  ASSERT_EQ(saved.map.num<MapLine>(), map().num<MapLine>());
  EXPECT_EQ(saved.map.index().size(), 3u);
  EXPECT_EQ(saved.map.keyframe_ids(), (std::vector<KeyFrameId>{0_kf, 1_kf, 2_kf}))
      << "without gaps";

  const KeyFrame& old = *map().keyframe(2_kf);
  const KeyFrame& same = *saved.map.keyframe(1_kf);
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

  const MapPoint& point = *map().Find(map().ids<MapPoint>().back());
  const MapPoint& same_point = *saved.map.Find(saved.map.ids<MapPoint>().back());
  EXPECT_EQ(same_point.p_W, point.p_W);
  EXPECT_EQ(same_point.normal_W, point.normal_W);
  EXPECT_EQ(same_point.max_distance, point.max_distance);
  EXPECT_EQ(same_point.descriptor, point.descriptor);
  EXPECT_EQ(same_point.observations.size(), point.observations.size());
  const MapLine& line = *saved.map.Find(saved.map.ids<MapLine>().back());
  EXPECT_EQ(line.segment_W.q(), map().Find(map().ids<MapLine>().back())->segment_W.q());
  EXPECT_TRUE(line.has_descriptor);
}

TEST_F(MapIoTest, SubmapsStayApartOrJoinedAsTheyWere) {
  const Eigen::Vector3d down(0.0, 0.1, -9.8);
  map().SetGravity(down);
  const SubmapId dropped = map().AddSubmap();  // a gap
  std::vector<SubmapId> submaps;
  for (int i = 0; i < 3; ++i) {
    submaps.push_back(map().AddSubmap());
    map().AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[1], submaps.back());
  }
  map().Join(submaps[0], submaps[2]);
  ASSERT_EQ(map().NumKeyFramesOf(dropped), 0U);
  Save();
  const Map loaded = LoadMap(path).map;
  EXPECT_EQ(loaded.roots(), (std::vector<SubmapId>{kFirstSubmap, SubmapId(1), SubmapId(2)}));
  EXPECT_EQ(loaded.KeyFramesOf(SubmapId(1)), (std::vector<KeyFrameId>{3_kf, 5_kf}));
  EXPECT_EQ(loaded.KeyFramesOf(SubmapId(2)), std::vector<KeyFrameId>{4_kf});
  EXPECT_TRUE(loaded.IsOrigin(3_kf));
  EXPECT_EQ(loaded.gravity_W(), down);
  EXPECT_FALSE(loaded.gravity_W(SubmapId(1)));
}

TEST_F(MapIoTest, ReadsAMapFromBeforeSubmaps) {
  Save();
  // Removes the fields of later versions, whose positions are known with only one keyframe.
  Map one;
  one.AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[2]);
  SaveMap(path, IdealSensor().camera, one);
  std::string bytes = Bytes();
  constexpr std::size_t kHeader = 24, kCamera = 40, kSubmaps = 4 + 4 + 1, kCount = 4, kSubmap = 4;
  constexpr std::size_t kEvidence = 8 + 4, kLandmarks = 4 + 4;  // no depth grid, nothing seen
  constexpr std::size_t kFactors = 4 + 4;                       // nothing measured
  const FrameFeatures& features = *map().keyframe(0_kf)->frame.features;
  const std::size_t noise = 9 * features.points.size() + 8 * features.lines.size();
  bytes.erase(bytes.size() - kFactors, kFactors);
  bytes.erase(bytes.size() - kLandmarks - noise - kEvidence, kEvidence + noise);
  bytes.erase(kHeader + kCamera + kKind + kSubmaps + kCount, kSubmap);
  bytes.erase(kHeader + kCamera, kKind + kSubmaps);
  const std::uint32_t version = 1;
  const std::uint64_t size = bytes.size() - kHeader;
  std::memcpy(bytes.data() + 8, &version, 4);
  std::memcpy(bytes.data() + 16, &size, 8);
  Write(WithChecksum(bytes));
  const Map loaded = LoadMap(path).map;
  ASSERT_EQ(loaded.num_keyframes(), 1U);
  EXPECT_EQ(loaded.keyframe(0_kf)->T_WC.Matrix(), kPoses[2].Matrix());
  EXPECT_EQ(loaded.roots(), std::vector<SubmapId>{kFirstSubmap});
}

TEST_F(MapIoTest, NoiseOfFeaturesIsKept) {
  SaveEdited([](FrameFeatures& features) {
    features.points[3].noise = {.px = 0.5F, .depth = 1.25F};
    features.points[3].refined = true;
    features.lines[1].noise = {.px = 0.75F, .depth = 1.5F};
  });
  const Map loaded = LoadMap(path).map;
  const FrameFeatures& same = *loaded.keyframe(loaded.keyframe_ids().back())->frame.features;
  EXPECT_EQ(same.points[3].noise.px, 0.5F);
  EXPECT_EQ(same.points[3].noise.depth, 1.25F);
  EXPECT_TRUE(same.points[3].refined);
  EXPECT_EQ(same.points[2].noise.px, 1.0F);
  EXPECT_FALSE(same.points[2].refined);
  EXPECT_EQ(same.lines[1].noise.px, 0.75F);
  EXPECT_EQ(same.lines[1].noise.depth, 1.5F);
}

TEST_F(MapIoTest, ReadsAMapWrittenBeforeRefinedCornersWereMarked) {
  Map one;
  FrameFeatures features = *map().keyframe(0_kf)->frame.features;
  for (PointFeature& point : features.points) point.noise = {.px = 0.5F, .depth = 1.25F};
  one.AddKeyFrame({.features = std::make_shared<const FrameFeatures>(features)}, kPoses[2]);
  SaveMap(path, IdealSensor().camera, one);
  std::string bytes = Bytes();
  // Counted from the end: no factors, no evidence, the noise of lines, that of points.
  std::size_t end = bytes.size() - 16 - 8 * features.lines.size();
  for (std::size_t i = 0; i < features.points.size(); ++i, end -= 9) bytes.erase(end - 1, 1);
  const std::uint32_t version = 4;
  const std::uint64_t size = bytes.size() - 24;
  std::memcpy(bytes.data() + 8, &version, 4);
  std::memcpy(bytes.data() + 16, &size, 8);
  Write(WithChecksum(bytes));
  const Map loaded = LoadMap(path).map;
  const FrameFeatures& same = *loaded.keyframe(0_kf)->frame.features;
  ASSERT_EQ(same.points.size(), features.points.size());
  for (const PointFeature& point : same.points) {
    EXPECT_FALSE(point.refined);
    EXPECT_EQ(point.noise.px, 0.5F);
    EXPECT_EQ(point.noise.depth, 1.25F);
  }
}

// The data by which another map is compared with this one: docs/submaps.md.

TEST_F(MapIoTest, DepthAndWhatAKeyFrameFoundAreKept) {
  const DepthGrid grid(IdealSensor().camera);
  cv::Mat depth(grid.camera().height, grid.camera().width, CV_32FC1);
  for (int i = 0; i < static_cast<int>(depth.total()); ++i)
    depth.ptr<float>()[i] = 0.001F * static_cast<float>(i);
  SaveEdited([&](FrameFeatures& features) { features.depth_grid = depth; }, 0.625);
  const Map loaded = LoadMap(path).map;
  const KeyFrame& keyframe = *loaded.keyframe(loaded.keyframe_ids().back());
  EXPECT_EQ(keyframe.found, 0.625);
  const cv::Mat& same = keyframe.frame.features->depth_grid;
  ASSERT_EQ(same.size(), depth.size());
  EXPECT_EQ(cv::norm(same, depth, cv::NORM_INF), 0.0);
  EXPECT_TRUE(loaded.keyframe(0_kf)->frame.features->depth_grid.empty()) << "it had none";
}

TEST_F(MapIoTest, DoesNotKeepTheDepthOfDynamicObjects) {
  Map seen;
  KeyFrame& keyframe = seen.AddKeyFrame(map().keyframe(0_kf)->frame, kPoses[0]);
  keyframe.depth_grid = cv::Mat(60, 80, CV_32FC1, cv::Scalar(2.0));
  keyframe.depth_grid.at<float>(7, 9) = 0.0F;
  SaveMap(path, IdealSensor().camera, seen);
  const Map loaded = LoadMap(path).map;
  EXPECT_EQ(cv::norm(loaded.keyframe(0_kf)->depth_grid, seen.keyframe(0_kf)->depth_grid), 0.0);
}

TEST_F(MapIoTest, LandmarksThatNoKeyFrameKnowsTheDepthOfAreKept) {
  const Map& with_depth = map();
  Map without;
  const LineId line = without.Add<MapLine>(Segment3({-0.3, 0.1, 2.0}, {0.4, 0.2, 2.5}), 0).id;
  const PointId point = without.Add<MapPoint>({0.1, 0.2, 2.0}, 0).id;
  for (const KeyFrameId id : with_depth.keyframe_ids()) {
    const KeyFrame& keyframe = *with_depth.keyframe(id);
    Frame frame = keyframe.frame;
    FrameFeatures features = *frame.features;
    for (PointFeature& feature : features.points) feature.depth = feature.depth_sigma = 0.0;
    for (LineFeature& feature : features.lines) feature.segment_C.reset();
    frame.features = std::make_shared<const FrameFeatures>(std::move(features));
    const KeyFrameId added = without.AddKeyFrame(frame, keyframe.T_WC).id;
    EXPECT_TRUE(without.Observe(added, 2, line));
    EXPECT_TRUE(without.Observe(added, 3, point));
  }
  SaveMap(path, IdealSensor().camera, without);
  const Map loaded = LoadMap(path).map;
  ASSERT_EQ(loaded.num<MapLine>(), 1U);
  ASSERT_EQ(loaded.num<MapPoint>(), 1U);
  const MapLine& same = *loaded.Find(loaded.ids<MapLine>().front());
  EXPECT_EQ(same.segment_W.p(), without.Find(line)->segment_W.p());
  ASSERT_EQ(same.observations.size(), without.Find(line)->observations.size());
  EXPECT_EQ(loaded.Find(loaded.ids<MapPoint>().front())->observations.size(),
            same.observations.size());
  for (const Observation& o : same.observations) {
    const FrameFeatures& features = *loaded.keyframe(o.keyframe)->frame.features;
    const LineFeature& seen = features.lines[static_cast<std::size_t>(o.index)];
    EXPECT_FALSE(seen.segment_C);
    EXPECT_EQ(MeasurementModel::Dimension(seen), 2);
    EXPECT_EQ(features.points[3].depth, 0.0);
  }
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

TEST_F(MapIoTest, KeepsTheFeatureTypeOfThePoints) {
  const FeatureType kind{.name = "mine",
                         .descriptor = DescriptorType::kFloat,
                         .columns = 96,
                         .pyramid = {.levels = 3, .scale_factor = 1.7},
                         .low_contrast_response = 0.25F};
  Map mine = map().Clone();
  mine.SetFeatureType(kind);
  SaveMap(path, IdealSensor().camera, mine);
  const Map loaded = LoadMap(path).map;
  EXPECT_EQ(loaded.feature_type().name, kind.name);
  EXPECT_EQ(loaded.feature_type().descriptor, kind.descriptor);
  EXPECT_EQ(loaded.feature_type().columns, kind.columns);
  EXPECT_EQ(loaded.feature_type().pyramid.levels, kind.pyramid.levels);
  EXPECT_EQ(loaded.feature_type().pyramid.scale_factor, kind.pyramid.scale_factor);
  EXPECT_EQ(loaded.feature_type().low_contrast_response, kind.low_contrast_response);
  EXPECT_EQ(loaded.num<MapPoint>(), map().num<MapPoint>());
  mine.SetFeatureType({.name = "mine", .columns = 0});
  SaveMap(path, IdealSensor().camera, mine);
  ExpectError("is damaged: points by mine: FeatureType::columns must be 1 to 4096, is 0");
}

TEST_F(MapIoTest, PositionsAndMotionsAreKeptAndOthersAreCounted) {
  EXPECT_EQ(SaveMap(path, IdealSensor().camera, map()), 0u);
  AddFactors(map());
  EXPECT_EQ(SaveMap(path, IdealSensor().camera, map()), 2u);
  const Map loaded = LoadMap(path).map;
  const UserFactors& factors = loaded.factors();
  ASSERT_EQ(factors.frames().size(), 2u);
  const ReferenceFrameId gps = factors.frames()[0], marker = factors.frames()[1];
  EXPECT_TRUE(factors.frame(gps).upright);
  EXPECT_FALSE(factors.frame(marker).upright);
  ASSERT_TRUE(factors.T_FW(gps, kFirstSubmap));
  EXPECT_EQ(factors.T_FW(gps, kFirstSubmap)->Matrix(),
            map().factors().T_FW(gps, kFirstSubmap)->Matrix());
  EXPECT_FALSE(factors.T_FW(marker, kFirstSubmap));
  ASSERT_EQ(factors.all().size(), 3u);
  for (std::size_t i = 0; i < 2; ++i) {
    const MapFactor &old = map().factors().all()[i], &same = factors.all()[i];
    EXPECT_EQ(same.frame, old.frame);
    ASSERT_EQ(same.poses.size(), 1u);
    EXPECT_EQ(same.poses[0].keyframe, i == 0 ? 1_kf : 0_kf) << "without gaps";
    EXPECT_EQ(same.poses[0].T_KB.Matrix(), old.poses[0].T_KB.Matrix());
    const Pose T_WB = Pose::FromTangent({3, 2, 1}, {0.3, 0.2, 0.1});
    const Pose T_FW = *factors.T_FW(gps, kFirstSubmap);
    const double* const blocks[] = {T_WB.data(), T_FW.data()};
    Eigen::Vector3d before, after;
    ASSERT_TRUE(old.cost->Evaluate(blocks, before.data(), nullptr));
    ASSERT_TRUE(same.cost->Evaluate(blocks, after.data(), nullptr));
    EXPECT_EQ(before, after);
  }
  for (const double s : {1.0, 7.0, 8.0, 100.0}) {
    double before[3], after[3];
    map().factors().all()[0].loss->Evaluate(s, before);
    factors.all()[0].loss->Evaluate(s, after);
    EXPECT_EQ(before[0], after[0]) << s;
  }
  EXPECT_EQ(factors.all()[1].loss, nullptr);
  const MapFactor &old = map().factors().all().back(), &same = factors.all().back();
  EXPECT_EQ(same.frame, kNoId);
  ASSERT_EQ(same.poses.size(), 2u);
  EXPECT_EQ(same.poses[0].keyframe, 0_kf);
  EXPECT_EQ(same.poses[1].keyframe, 1_kf) << "without gaps";
  EXPECT_EQ(same.poses[1].T_KB.Matrix(), old.poses[1].T_KB.Matrix());
  const auto &measured = dynamic_cast<const RelativePose&>(*old.cost),
             &read = dynamic_cast<const RelativePose&>(*same.cost);
  EXPECT_EQ(read.Z().Matrix(), measured.Z().Matrix());
  EXPECT_EQ(read.sqrt_information(), measured.sqrt_information());
  EXPECT_NE(same.loss, nullptr);
  const std::string bytes = Bytes();
  EXPECT_EQ(SaveMap(path, IdealSensor().camera, loaded), 0u);
  EXPECT_EQ(Bytes(), bytes);
}

TEST_F(MapIoTest, OnlyAMapWithMotionsNeedsTheirVersion) {
  Save();
  EXPECT_EQ(Bytes()[8], 5);
  AddFactors(map());
  Save();
  EXPECT_EQ(Bytes()[8], 6);
}

TEST_F(MapIoTest, AFailedSaveLeavesTheOldFile) {
  Save();
  const std::string bytes = Bytes();
  EXPECT_THROW(SaveMap(path / "below_a_file", IdealSensor().camera, map()), IoError);
  EXPECT_EQ(Bytes(), bytes);
}

}  // namespace
}  // namespace highwall::map_io_test
