// SlamSystem with points other than ORB: SIFT (floats, 15 levels) on a walk around a room and on,
// and a user's extractor (512 bits, one level, no orientation). Takes some twenty seconds.
#include <memory>
#include <utility>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/features/orb_extractor.h>
#include <highwall/frontend/system/slam_system.h>
#include <simulate/scenes/room.h>

#include "support/message_of.h"
#include "support/rendered_walk.h"
#include "support/temporary_directory.h"

namespace highwall::slam_user_features_test {
namespace {

using testing::RenderedWalk;

// cv::BRISK's descriptors of 64 bytes, only on corners of the full-resolution image.
class BriskPoints final : public PointExtractor {
 public:
  const FeatureType& kind() const override { return kind_; }

  ExtractedPoints Extract(const cv::Mat& gray) override {
    ExtractedPoints points;
    corners_->detect(gray, points.keypoints);
    cv::KeyPointsFilter::retainBest(points.keypoints, 800);
    brisk_->compute(gray, points.keypoints, points.descriptors);
    for (cv::KeyPoint& keypoint : points.keypoints) keypoint.angle = -1.0F;
    return points;
  }

 private:
  FeatureType kind_{.name = "brisk", .columns = 64, .pyramid = {.levels = 1, .scale_factor = 2.0}};
  cv::Ptr<cv::FastFeatureDetector> corners_ = cv::FastFeatureDetector::create(15);
  cv::Ptr<cv::BRISK> brisk_ = cv::BRISK::create(15, 0);
};

class SlamUserFeaturesTest : public ::testing::Test {
 protected:
  static constexpr double kLap = 10.0, kSeconds = 15.0, kFps = 10.0;

  static void SetUpTestSuite() {
    simulate::SimulationOptions options;
    options.seed = 5;
    options.duration = kSeconds;
    options.fps = kFps;
    options.camera = Sensor().camera;
    options.sensor.noise = simulate::SensorNoise::kKinect;
    options.sensor.noise_ratio = 1.0;  // the bounds below are for the specified noise
    const simulate::Simulation room(simulate::MakeRoom(options.seed),
                                    simulate::MakeRoomTrajectory(kLap, options.seed), options);
    walk_ = std::make_unique<RenderedWalk>(testing::Render(room));
  }
  static void TearDownTestSuite() { walk_.reset(); }

  static RgbdSensor Sensor() {
    return {.camera = {
                .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5}};
  }
  // Uses points alone: no line may contribute.
  static SlamOptions Options(PointDetector detector) {
    SlamOptions options = Deterministic({});
    options.frame.use_lines = false;
    options.frame.point_detector = detector;
    return options;
  }
  // Tracks frames [begin, end); returns how many are lost.
  static int Walk(SlamSystem& slam, std::size_t begin, std::size_t end) {
    int lost = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (slam.Track(walk_->images[i]).state != TrackingState::kTracking) ++lost;
    }
    return lost;
  }
  static double Rmse(const SlamSystem& slam) {
    return AbsolutePoseError(walk_->truth, slam.trajectory()).statistics.rmse;
  }

  static std::unique_ptr<const RenderedWalk> walk_;
};

std::unique_ptr<const RenderedWalk> SlamUserFeaturesTest::walk_;

TEST_F(SlamUserFeaturesTest, SiftTracksClosesTheLoopAndItsMapIsContinued) {
  SlamSystem slam(Sensor(), Options(PointDetector::kSift));
  int closed = 0;
  slam.SetCallbacks({.on_loop = [&](const LoopReport& report) {
    if (report.accepted && !report.bundle) ++closed;
  }});
  EXPECT_EQ(Walk(slam, 0, walk_->images.size()), 0);
  slam.Finish();
  EXPECT_GE(closed, 1);
  // The bound is that for ORB, points and lines (slam_loop_test.cc).
  EXPECT_LT(Rmse(slam), 0.006);
  EXPECT_EQ(slam.map().feature_type().name, "sift");

  const testing::TemporaryDirectory folder;
  SaveMap(folder.path() / "sift.hwmap", Sensor().camera, slam.map());
  Map loaded = LoadMap(folder.path() / "sift.hwmap").map;
  EXPECT_EQ(loaded.feature_type().name, "sift");
  const std::string message = testing::MessageOf<InvalidArgument>(
      [&] { SlamSystem(Sensor(), Options(PointDetector::kOrb), {.map = loaded.Clone()}); });
  EXPECT_EQ(message,
            "SlamSystem: the points of the map are by sift, those of its images would be by orb");
  SlamOptions localize = Options(PointDetector::kSift);
  localize.localize_only = true;
  localize.loops.enabled = false;
  SlamSystem again(Sensor(), localize, {.map = std::move(loaded)});
  EXPECT_LE(Walk(again, 40, 60), 1);
  // The comparison is in the frame of the map, which differs from that of the truth: both runs are
  // compared.
  const Trajectory first = slam.trajectory(), second = again.trajectory();
  EXPECT_LT(AbsolutePoseError(first, second).statistics.rmse, 0.005);
}

TEST_F(SlamUserFeaturesTest, ContinuesAMapWithThePyramidThatItWasMadeWith) {
  const testing::TemporaryDirectory folder;
  Map map;
  map.AddKeyFrame({.features = std::make_shared<const FrameFeatures>()}, Pose());
  const auto refusal = [&](const Map& given, const FrameBuilderOptions& frame) {
    return testing::MessageOf<InvalidArgument>(
        [&] { SlamSystem(Sensor(), {.frame = frame}, {.map = given.Clone()}); });
  };
  FrameBuilderOptions coarse;
  coarse.orb.pyramid = {.levels = 4, .scale_factor = 1.5};
  map.SetFeatureType({});
  SaveMap(folder.path() / "map.hwmap", Sensor().camera, map);
  EXPECT_EQ(refusal(LoadMap(folder.path() / "map.hwmap").map, coarse),
            "SlamSystem: the points of the map are by orb in 8 levels of 1.2, those of its images "
            "would be by orb in 4 levels of 1.5");
}

TEST_F(SlamUserFeaturesTest, AMapThatDoesNotSayItsPyramidIsTaken) {
  Map map;  // as from a file before version 4
  map.AddKeyFrame({.features = std::make_shared<const FrameFeatures>()}, Pose());
  FrameBuilderOptions coarse;
  coarse.orb.pyramid.levels = 4;
  const SlamSystem slam(Sensor(), {.frame = coarse}, {.map = std::move(map)});
  EXPECT_EQ(slam.map().feature_type().pyramid.levels, 4);
}

// An extractor that returns the same memory each time.
class Reusing final : public PointExtractor {
 public:
  const FeatureType& kind() const override { return orb_.kind(); }
  ExtractedPoints Extract(const cv::Mat& gray) override {
    ExtractedPoints points = orb_.Extract(gray);
    cv::Mat own = descriptors_.rowRange(0, points.descriptors.rows);
    points.descriptors.copyTo(own);
    points.descriptors = own;
    return points;
  }

 private:
  OrbExtractor orb_;
  cv::Mat descriptors_ = cv::Mat(5000, 32, CV_8U);
};

TEST_F(SlamUserFeaturesTest, AnExtractorMayUseTheMemoryOfItsDescriptorsAgain) {
  constexpr std::size_t kFrames = 10;
  SlamSystem built_in(Sensor(), Options(PointDetector::kOrb));
  SlamSystem given(Sensor(), Options(PointDetector::kOrb), {.points = std::make_shared<Reusing>()});
  EXPECT_EQ(Walk(built_in, 0, kFrames), 0);
  EXPECT_EQ(Walk(given, 0, kFrames), 0);
  const Map &a = built_in.map(), &b = given.map();
  ASSERT_GE(a.num_keyframes(), 2U);
  ASSERT_EQ(a.keyframe_ids(), b.keyframe_ids());
  for (const KeyFrameId id : a.keyframe_ids()) {
    const cv::Mat &x = a.keyframe(id)->frame.features->point_descriptors,
                  &y = b.keyframe(id)->frame.features->point_descriptors;
    ASSERT_EQ(x.rows, y.rows);
    EXPECT_EQ(cv::countNonZero(x != y), 0);
  }
}

TEST_F(SlamUserFeaturesTest, OrbThatIsGivenGivesTheSameBitForBit) {
  constexpr std::size_t kFrames = 30;
  SlamSystem built_in(Sensor(), Options(PointDetector::kOrb));
  SlamSystem given(Sensor(), Options(PointDetector::kOrb),
                   {.points = std::make_shared<OrbExtractor>()});
  EXPECT_EQ(Walk(built_in, 0, kFrames), 0);
  EXPECT_EQ(Walk(given, 0, kFrames), 0);
  const Trajectory a = built_in.trajectory(), b = given.trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].pose.Matrix(), b[i].pose.Matrix());
}

TEST_F(SlamUserFeaturesTest, AnExtractorOfTheUsersIsTracked) {
  constexpr std::size_t kFrames = 60;
  SlamSystem slam(Sensor(), Options(PointDetector::kOrb),
                  {.points = std::make_shared<BriskPoints>()});
  EXPECT_EQ(Walk(slam, 0, kFrames), 0);
  EXPECT_EQ(slam.map().feature_type().name, "brisk");
  EXPECT_EQ(slam.trajectory().size(), kFrames);
  EXPECT_LT(Rmse(slam), 0.02);
}

TEST_F(SlamUserFeaturesTest, AnExceptionOfAnExtractorComesOutOfTrack) {
  class Broken final : public PointExtractor {
   public:
    const FeatureType& kind() const override { return kind_; }
    ExtractedPoints Extract(const cv::Mat&) override { throw std::runtime_error("no battery"); }

   private:
    FeatureType kind_{.name = "broken"};
  };
  SlamSystem slam(Sensor(), {}, {.points = std::make_shared<Broken>()});
  EXPECT_EQ(testing::MessageOf<std::runtime_error>([&] { slam.Track(walk_->images[0]); }),
            "no battery");
}

}  // namespace
}  // namespace highwall::slam_user_features_test
