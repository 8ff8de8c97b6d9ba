#include <highwall/frontend/system/slam_system.h>

#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <simulate/scenes/room.h>

#include "support/message_of.h"
#include "support/rendered_walk.h"

namespace highwall::slam_system_test {
namespace {

using testing::RenderedWalk;

constexpr int kFrames = 60;

PinholeCamera SmallCamera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

// Two seconds of a walk through a textured room, rendered once for all tests.
class SlamSystemTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    simulate::SimulationOptions options;
    options.seed = 3;
    options.duration = kFrames / 30.0;
    options.camera = SmallCamera();
    options.sensor.noise = simulate::SensorNoise::kKinect;
    walk_ = std::make_unique<RenderedWalk>(testing::Render(simulate::SimulateRoom(options)));
  }
  static void TearDownTestSuite() { walk_.reset(); }

  static RgbdSensor Sensor() { return {.camera = SmallCamera()}; }
  static const std::vector<RgbdImage>& Images() { return walk_->images; }
  static double Rmse(const Trajectory& estimate) {
    return AbsolutePoseError(walk_->truth, estimate).statistics.rmse;
  }
  static RgbdImage Blank(Stamp stamp) {
    return {stamp, cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(128)),
            cv::Mat(240, 320, CV_32FC1, 2.0F)};
  }

  static std::unique_ptr<const RenderedWalk> walk_;
};

std::unique_ptr<const RenderedWalk> SlamSystemTest::walk_;

TEST_F(SlamSystemTest, RefusesDepthInTheUnitOfTheSensorAndSaysSo) {
  SlamSystem system(Sensor());
  RgbdImage raw = Images().front();
  raw.depth = cv::Mat(raw.depth * 1000.0);  // a copy: images are shared by the tests
  const auto track = [&] { system.Track(raw); };
  testing::ExpectError("depth must be in metres, but all of it lies beyond 100 m (median ", track);
  testing::ExpectError("divide it by the depth factor", track);
  // The rejected image has no effect; neither missing depth nor far depth after near depth is
  // rejected.
  RgbdImage empty = Images()[0];
  empty.depth = cv::Mat(240, 320, CV_32FC1, 0.0F);
  system.Track(empty);
  EXPECT_EQ(system.Track(Images()[1]).state, TrackingState::kTracking);
  raw.stamp = Images()[2].stamp;
  EXPECT_NO_THROW(system.Track(raw));
}

TEST_F(SlamSystemTest, TracksARoomToACentimetre) {
  SlamSystem system(Sensor());
  Trajectory causal;
  int keyframes = 0;
  for (const RgbdImage& image : Images()) {
    const FrameResult result = system.Track(image);
    ASSERT_EQ(result.state, TrackingState::kTracking) << causal.size();
    EXPECT_EQ(result.stamp, image.stamp);
    EXPECT_FALSE(result.relocalized);
    EXPECT_GT(result.points, 100);
    EXPECT_GT(result.lines, 5);
    EXPECT_LE(result.matched_points, result.points);
    EXPECT_GE(result.times.features, 0.0);
    keyframes += result.mapping ? 1 : 0;
    causal.push_back({result.stamp, result.T_WC});
  }
  EXPECT_EQ(system.trajectory().size(), Images().size());
  EXPECT_LT(Rmse(system.trajectory()), 0.01);
  EXPECT_LT(Rmse(causal), 0.015);
  EXPECT_GE(keyframes, 2);
  EXPECT_LT(keyframes, kFrames / 2);
  EXPECT_EQ(system.keyframe_trajectory().size(), system.map().num_keyframes());
  EXPECT_LT(Rmse(system.keyframe_trajectory()), 0.01);
  EXPECT_GT(system.map().num<MapPoint>(), 300u);
  EXPECT_GT(system.map().num<MapLine>(), 10u);
}

TEST_F(SlamSystemTest, WorldBeginsAtTheFirstCameraWithZUp) {
  SlamSystem system(Sensor());
  const FrameResult first = system.Track(Images()[0]);
  ASSERT_EQ(first.state, TrackingState::kTracking);
  ASSERT_TRUE(first.mapping);
  EXPECT_TRUE(first.T_WC.p().isZero());
  EXPECT_TRUE(
      (first.T_WC.R() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-15));
  EXPECT_TRUE(
      (first.T_WC.R() * Eigen::Vector3d::UnitY()).isApprox(-Eigen::Vector3d::UnitZ(), 1e-15));
}

TEST_F(SlamSystemTest, TracksWithPointsAlone) {
  SlamOptions options;
  options.frame.use_lines = false;
  SlamSystem system(Sensor(), options);
  for (std::size_t i = 0; i < 30; ++i) {
    const FrameResult result = system.Track(Images()[i]);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_EQ(result.lines, 0);
  }
  EXPECT_EQ(system.map().num<MapLine>(), 0u);
  EXPECT_LT(Rmse(system.trajectory()), 0.01);
}

TEST_F(SlamSystemTest, BlankImagesAreLostAndThePlaceIsFoundAgain) {
  SlamSystem system(Sensor());
  for (std::size_t i = 0; i < 25; ++i) {
    ASSERT_EQ(system.Track(Images()[i]).state, TrackingState::kTracking) << i;
  }
  const std::size_t keyframes = system.map().num_keyframes();
  for (std::size_t i = 25; i < 30; ++i) {
    const FrameResult result = system.Track(Blank(Images()[i].stamp));
    EXPECT_EQ(result.state, TrackingState::kLost);
    EXPECT_FALSE(result.mapping);
    EXPECT_EQ(result.matched_points, 0);
  }
  EXPECT_EQ(system.map().num_keyframes(), keyframes) << "the map is kept";
  for (std::size_t i = 30; i < 40; ++i) {
    const FrameResult result = system.Track(Images()[i]);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_EQ(result.relocalized, i == 30);
  }
  EXPECT_EQ(system.trajectory().size(), 35u) << "no pose for what was lost";
  EXPECT_LT(Rmse(system.trajectory()), 0.01);
}

TEST_F(SlamSystemTest, WaitsForAFirstFrameWithDepth) {
  SlamSystem system(Sensor());
  RgbdImage flat = Images()[0];
  flat.depth = cv::Mat(240, 320, CV_32FC1, cv::Scalar(0.0));
  EXPECT_EQ(system.Track(flat).state, TrackingState::kInitializing);
  EXPECT_EQ(system.map().num_keyframes(), 0u);
  EXPECT_TRUE(system.trajectory().empty());
  const FrameResult result = system.Track(Images()[1]);
  EXPECT_EQ(result.state, TrackingState::kTracking);
  EXPECT_TRUE(result.mapping);
}

TEST_F(SlamSystemTest, RepeatsBitForBitInSynchronousMode) {
  std::vector<Eigen::Matrix4d> poses[2];
  for (std::vector<Eigen::Matrix4d>& run : poses) {
    SlamSystem system(Sensor(), Deterministic({}));
    for (std::size_t i = 0; i < 40; ++i) {
      ASSERT_EQ(system.Track(Images()[i]).state, TrackingState::kTracking) << i;
    }
    for (const StampedPose& pose : system.trajectory()) {
      run.push_back(pose.pose.Matrix());
    }
  }
  ASSERT_EQ(poses[0].size(), 40u);
  EXPECT_EQ(poses[0], poses[1]);
}

TEST_F(SlamSystemTest, AdjustmentsComeBetweenFramesAndTrackingFollows) {
  SlamSystem system(Sensor());
  int keyframes = 0, adjustments = 0;
  for (const RgbdImage& image : Images()) {
    const FrameResult result = system.Track(image);
    keyframes += result.mapping ? 1 : 0;
    adjustments += result.adjustment ? 1 : 0;
    if (!result.mapping) continue;
    EXPECT_FALSE(result.mapping->bundle.usable) << "not before Track returns";
  }
  system.Finish();
  EXPECT_GE(adjustments, keyframes - 2) << "of all but the first and, perhaps, the last";
  EXPECT_LE(adjustments, keyframes - 1);
  EXPECT_LT(Rmse(system.trajectory()), 0.01);
}

TEST_F(SlamSystemTest, CallbacksReportEveryFrameAndKeyFrame) {
  SlamSystem system(Sensor());
  const auto caller = std::this_thread::get_id();
  std::vector<Stamp> frames, keyframes;
  int maps = 0;
  system.SetCallbacks({.on_keyframe =
                           [&](const KeyFrame& keyframe, const RgbdImage& image) {
                             EXPECT_EQ(keyframe.frame.stamp, image.stamp);
                             EXPECT_EQ(system.map().keyframe(keyframe.id), &keyframe);
                             keyframes.push_back(image.stamp);
                           },
                       .on_loop = [](const LoopReport&) { FAIL() << "there is none"; },
                       .on_map = [&](const Map&) { ++maps; },
                       .on_frame =
                           [&](const FrameResult& result) {
                             EXPECT_EQ(std::this_thread::get_id(), caller);
                             EXPECT_EQ(result.mapping.has_value(),
                                       !keyframes.empty() && keyframes.back() == result.stamp);
                             frames.push_back(result.stamp);
                           }});
  std::vector<Stamp> expected;
  std::size_t made = 0;
  for (std::size_t i = 0; i < 30; ++i) {
    // Lost frames are reported as well.
    const RgbdImage& image = i == 20 ? Blank(Images()[i].stamp) : Images()[i];
    made += system.Track(image).mapping ? 1u : 0u;
    expected.push_back(image.stamp);
  }
  EXPECT_EQ(frames, expected);
  EXPECT_EQ(keyframes.size(), made);
  system.Finish();
  EXPECT_EQ(maps, 0);
  ASSERT_TRUE(system.AdjustAll().usable);
  EXPECT_EQ(maps, 1);
}

// Input of a dense map: each keyframe once, and finally the poses of all of them.
TEST_F(SlamSystemTest, EventsHoldEachKeyframeAndItsLastPlace) {
  SlamSystem system(Sensor());
  std::map<std::int64_t, Pose> keyframes;
  system.SetCallbacks({.on_keyframes = [&](const KeyframeEvent& event) {
    EXPECT_FALSE(event.empty());
    for (const std::int64_t id : event.removed) keyframes.erase(id);
    if (event.places) {
      for (auto& [id, T_WC] : keyframes) T_WC = event.places->at(id).T_WC;
    }
    for (const KeyframeView& view : event.added) {
      EXPECT_TRUE(keyframes.emplace(view.id, view.place.T_WC).second);
      EXPECT_EQ(view.depth->type(), CV_32FC1);
      EXPECT_EQ(view.bgr->size(), view.depth->size());
    }
  }});
  for (std::size_t i = 0; i < 30; ++i) system.Track(Images()[i]);
  EXPECT_FALSE(system.keyframe_view(KeyFrameId(1000), Images()[0]));
  const std::size_t waiting = system.waiting_keyframes().added.size();
  EXPECT_EQ(keyframes.size() + waiting, system.map().num_keyframes());
  system.Finish();
  EXPECT_TRUE(system.waiting_keyframes().added.empty());
  ASSERT_TRUE(system.AdjustAll().usable);
  ASSERT_EQ(keyframes.size(), system.map().num_keyframes());
  for (const auto& [id, T_WC] : keyframes) {
    EXPECT_EQ(T_WC.p(), system.map().keyframe(KeyFrameId(id))->T_WC.p());
  }
}

TEST_F(SlamSystemTest, WhileImagesWaitLoopsAreSearchedForEveryThirdKeyframe) {
  SlamSystem system(Sensor());
  system.SetBacklog(1);
  std::size_t keyframes = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    const FrameResult result = system.Track(Images()[i]);
    EXPECT_EQ(result.state, TrackingState::kTracking) << i;
    if (result.mapping) ++keyframes;
  }
  EXPECT_GT(keyframes, 1U);
  EXPECT_EQ(system.postponed().loop_searches, keyframes - keyframes / 3);
}

TEST_F(SlamSystemTest, StatesWhatItsPartsHoldInMemory) {
  SlamSystem system(Sensor(), {.threads = 0});
  const auto held = [&](const std::string& holder) {
    for (const MemoryShare& share : system.memory()) {
      if (share.holder == holder) return share.bytes;
    }
    ADD_FAILURE() << "nothing is stated about " << holder;
    return std::size_t{0};
  };
  EXPECT_EQ(held("features of keyframes"), 0U);
  std::size_t features = 0;  // of all frames, all of which the map or the refinement holds
  for (std::size_t i = 0; i < 10; ++i) {
    features += system.Track(Images()[i]).features->points.size();
  }
  // A point has its feature and its descriptor of 32 bytes; there are lines and grids too.
  const std::size_t least = features * (sizeof(PointFeature) + 32);
  EXPECT_GT(held("features of keyframes") + held("frames to be refined"), least);
  EXPECT_LT(held("features of keyframes") + held("frames to be refined"), 20 * least);
  const std::size_t points = system.map().num<MapPoint>();
  EXPECT_GE(held("points"), points * (sizeof(MapPoint) + sizeof(Observation)));
  EXPECT_GT(held("corner patches of points"), 0U);
  EXPECT_GT(held("index of places"), 0U);
  EXPECT_GE(held("poses of frames"), 10 * sizeof(Pose));
}

// No frame waits for both; with a backlog, the search is counted where it is left out.
TEST_F(SlamSystemTest, WithThreadsALoopIsSearchedWithTheFrameAfterAKeyframe) {
  const auto searches = [](int threads, std::size_t frames, bool finish) {
    SlamSystem system(Sensor(), {.threads = threads});
    system.SetBacklog(1);
    for (std::size_t i = 0; i < frames; ++i) {
      EXPECT_EQ(system.Track(Images()[i]).mapping.has_value(), i == 0);
    }
    if (finish) system.Finish();
    return system.postponed().loop_searches;
  };
  EXPECT_EQ(searches(0, 1, false), 1U);
  EXPECT_EQ(searches(2, 1, false), 0U);
  EXPECT_EQ(searches(2, 2, false), 1U);
  EXPECT_EQ(searches(2, 1, true), 1U);
}

TEST_F(SlamSystemTest, InSynchronousModeABacklogPostponesNoKeyframe) {
  // An adjustment ends before the next frame.
  SlamSystem with(Sensor(), {.threads = 0}), without(Sensor(), {.threads = 0});
  with.SetBacklog(2);
  for (std::size_t i = 0; i < 30; ++i) {
    with.Track(Images()[i]);
    without.Track(Images()[i]);
  }
  EXPECT_EQ(with.postponed().keyframes, 0U);
  EXPECT_EQ(with.map().keyframe_ids(), without.map().keyframe_ids());
}

TEST_F(SlamSystemTest, AnExceptionOfACallbackReachesTheCallerAndTheSystemContinues) {
  SlamSystem system(Sensor());
  system.SetCallbacks({.on_frame = [](const FrameResult&) { throw std::runtime_error("enough"); }});
  EXPECT_THROW(system.Track(Images()[0]), std::runtime_error);
  system.SetCallbacks({});
  EXPECT_EQ(system.Track(Images()[1]).state, TrackingState::kTracking);
  EXPECT_EQ(system.trajectory().size(), 2u);
}

TEST_F(SlamSystemTest, AnEventWhoseCallbackThrowsComesAgain) {
  SlamOptions options;
  options.tracker.moving.enabled = false;  // keyframes are released immediately
  SlamSystem system(Sensor(), options);
  std::vector<std::int64_t> keyframes;
  bool fails = true;
  system.SetCallbacks({.on_keyframes = [&](const KeyframeEvent& event) {
    if (std::exchange(fails, false)) throw std::runtime_error("enough");
    for (const KeyframeView& view : event.added) keyframes.push_back(view.id);
  }});
  EXPECT_THROW(system.Track(Images()[0]), std::runtime_error);
  EXPECT_EQ(system.Track(Images()[1]).state, TrackingState::kTracking);
  ASSERT_EQ(keyframes.size(), 1u);
  EXPECT_EQ(keyframes[0], system.map().keyframe_ids().front().value());
}

TEST_F(SlamSystemTest, RefusesStampsThatDoNotAscendAndContinues) {
  SlamSystem system(Sensor());
  system.Track(Images()[0]);
  EXPECT_THROW(system.Track(Images()[0]), InvalidArgument);
  RgbdImage earlier = Images()[1];
  earlier.stamp = Images()[0].stamp - 1;
  EXPECT_THROW(system.Track(earlier), InvalidArgument);
  EXPECT_EQ(system.Track(Images()[1]).state, TrackingState::kTracking);
}

TEST_F(SlamSystemTest, RefusesOneStampFarInTheFutureAndTakesTheOthers) {
  constexpr Stamp kYear = Stamp{365} * 86'400 * 1'000'000'000;
  SlamSystem system(Sensor());
  system.Track(Images()[0]);
  std::size_t next = 1;
  for (const Stamp wrong : {Images()[0].stamp + kYear, Stamp{kMaxStamp},
                            std::numeric_limits<Stamp>::max(), std::numeric_limits<Stamp>::min()}) {
    RgbdImage image = Images()[next];
    image.stamp = wrong;
    EXPECT_THROW(system.Track(image), InvalidArgument) << wrong;
    EXPECT_EQ(system.Track(Images()[next++]).state, TrackingState::kTracking) << wrong;
  }
  // The same wrong stamp again, later on, is not a pause.
  RgbdImage wrong = Images()[next];
  wrong.stamp = Images()[0].stamp + kYear;
  EXPECT_THROW(system.Track(wrong), InvalidArgument);
  EXPECT_NO_THROW(system.Track(Images()[next++]));
  EXPECT_THROW(system.Track(wrong), InvalidArgument);
  EXPECT_NO_THROW(system.Track(Images()[next++]));
  // A camera that did pause continues.
  RgbdImage later = Images()[next];
  later.stamp += kYear;
  testing::ExpectError("more than a day after", [&] { system.Track(later); });
  later.stamp += 33'000'000;
  EXPECT_NO_THROW(system.Track(later));
  EXPECT_EQ(system.trajectory().size(), next + 1);
}

TEST_F(SlamSystemTest, RefusesImagesOfAnotherSizeAndContinues) {
  SlamSystem system(Sensor());
  system.Track(Images()[0]);
  const RgbdImage& next = Images()[1];
  EXPECT_THROW(system.Track({next.stamp, cv::Mat(480, 640, CV_8UC3), cv::Mat(480, 640, CV_32FC1)}),
               InvalidArgument);
  EXPECT_THROW(system.Track({next.stamp, next.bgr, cv::Mat()}), InvalidArgument);
  EXPECT_EQ(system.Track(next).state, TrackingState::kTracking) << "its stamp was not used up";
}

TEST_F(SlamSystemTest, NoiseIsLearntOnFromAMapThatIsGiven) {
  SlamSystem first(Sensor(), Deterministic({}));
  for (const RgbdImage& image : Images()) first.Track(image);
  first.Finish();
  const SlamSystem blank(Sensor()), again(Sensor(), {}, {.map = first.map().Clone()});
  const SlamOptions known{.tracker = {.learn_noise = false}};
  const SlamSystem as_known(Sensor(), known, {.map = first.map().Clone()});
  // Ten keyframes are added at once, whereas the first system added them one by one: the estimate
  // is on the same side, and at least half as far. Corners of the finest level are many, and more
  // accurate than specified.
  const double beginning = blank.sensor().noise.point_px[0],
               learnt = first.sensor().noise.point_px[0];
  EXPECT_LT(learnt, 0.95 * beginning);
  EXPECT_LT(again.sensor().noise.point_px[0], 0.5 * (beginning + learnt));
  EXPECT_EQ(as_known.sensor().noise.point_px[0], beginning);
}

TEST_F(SlamSystemTest, TheFirstKeyframeGetsTheNoiseThatLaterOnesShow) {
  const auto of_first = [](const SlamSystem& system) {
    const Map& map = system.map();
    return map.keyframe(map.keyframe_ids().front())->frame.features->points.front().noise.px;
  };
  SlamSystem system(Sensor(), Deterministic({}));
  for (const RgbdImage& image : Images()) {
    system.Track(image);
    if (system.map().num_keyframes() == 1) {
      EXPECT_GE(of_first(system), 1.0F) << "a priori";
    }
  }
  ASSERT_GE(system.map().num_keyframes(), 4U);
  const float learnt = of_first(system);
  EXPECT_LT(learnt, 0.95F);

  SlamSystem more(Sensor(), Deterministic({}), {.map = system.map().Clone()});
  for (RgbdImage image : Images()) {
    image.stamp += FromSeconds(10.0);
    more.Track(image);
  }
  EXPECT_EQ(of_first(more), learnt) << "it was given with the map";
}

TEST_F(SlamSystemTest, LocalizingNeedsAMapAndNoImu) {
  const SlamOptions options{.localize_only = true};
  EXPECT_THROW(SlamSystem(Sensor(), options), InvalidArgument);
  SlamSystem first(Sensor());
  first.Track(Images()[0]);
  ImuCalibration imu;
  imu.rate = 200.0;
  EXPECT_THROW(SlamSystem(Sensor(), options, {.imu = imu, .map = first.map().Clone()}),
               InvalidArgument);
  SlamSystem localizing(Sensor(), options, {.map = first.map().Clone()});
  EXPECT_THROW(localizing.AdjustAll(), InvalidArgument);
}

// In the dark, colour comes at half the rate and is one image older than its depth.
TEST_F(SlamSystemTest, PosesOfLateColourAreThoseOfTheStamps) {
  constexpr std::size_t kDark = 11;
  SlamSystem slam(Sensor(), Deterministic({}));
  for (std::size_t i = 0; i < Images().size(); ++i) {
    RgbdImage image = Images()[i];
    if (i > kDark) image.bgr = Images()[i - 1 - i % 2].bgr;
    slam.Track(image);
  }
  slam.Finish();
  // At 0.45 m/s an image is 15 mm from the place of its stamp. Without late colour it is 1 mm; half
  // of the poses are interpolated here.
  EXPECT_LT(Rmse(slam.trajectory()), 0.006);
}

}  // namespace
}  // namespace highwall::slam_system_test
