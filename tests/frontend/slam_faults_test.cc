// SlamSystem under faults of readings and images: no input may cause an exception.
// HIGHWALL_FAULT_RUNS=1000 tries a thousand seeds.
#include <highwall/frontend/system/slam_system.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/frontend/calibration/depth_scale.h>
#include <simulate/scenes/room.h>
#include <opencv2/core.hpp>

#include "support/faulty_readings.h"
#include "support/rendered_walk.h"

namespace highwall::slam_faults_test {
namespace {

using testing::Fault;
using testing::RenderedWalk;
using testing::Uniform;

constexpr double kFps = 10.0;
constexpr int kFrames = 26;

PinholeCamera TinyCamera() {
  return {.width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5};
}

SlamOptions LightOptions() {
  SlamOptions options = Deterministic({});
  options.frame.orb.features = 400;
  return options;
}

// Two and a half seconds of a walk, rendered once.
const RenderedWalk& Walk() {
  static const RenderedWalk walk = [] {
    simulate::SimulationOptions options;
    options.seed = 3;
    options.fps = kFps;
    options.duration = kFrames / kFps;
    options.camera = TinyCamera();
    return testing::Render(simulate::SimulateRoom(options));
  }();
  return walk;
}

// Corrupts an image at random; its stamp stays.
void SpoilImage(std::mt19937& rng, std::vector<RgbdImage>& images) {
  const auto any = [&]() -> RgbdImage& {
    return images[static_cast<std::size_t>(Uniform(rng, 1, kFrames - 1))];
  };
  RgbdImage& image = any();
  image.bgr = image.bgr.clone();
  image.depth = image.depth.clone();
  const cv::Rect part(Uniform(rng, 0, 80), Uniform(rng, 0, 60), 80, 60);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  switch (Uniform(rng, 0, 7)) {
    case 0:
      image.depth(part) = cv::Scalar(static_cast<double>(nan));
      break;
    case 1:
      image.depth(part) = cv::Scalar(testing::Magnitude(rng, 1e-30, 1e30));
      break;
    case 2:
      image.depth.setTo(std::numeric_limits<double>::infinity());
      break;
    case 3:
      image.depth.setTo(0.0);
      break;
    case 4:
      image.bgr.setTo(Uniform(rng, 0, 255));
      break;
    case 5:
      cv::randu(image.bgr, 0, 256);
      break;
    case 6: {  // that of another instant
      const RgbdImage& other = any();
      other.bgr.copyTo(image.bgr);
      other.depth.copyTo(image.depth);
      break;
    }
    case 7: {  // frozen, for up to a second
      const std::size_t begin = static_cast<std::size_t>(Uniform(rng, 1, kFrames - 11));
      for (int i = 1, end = Uniform(rng, 2, 11); i < end; ++i) {
        images[begin + static_cast<std::size_t>(i)].bgr = images[begin].bgr;
        images[begin + static_cast<std::size_t>(i)].depth = images[begin].depth;
      }
      break;
    }
  }
}

void ExpectSound(const SlamSystem& system, const std::vector<FrameResult>& results) {
  std::set<Stamp> kept;
  for (const SubmapTrajectory& submap : system.submaps()) {
    for (const StampedPose& pose : submap.frames) {
      EXPECT_TRUE(pose.pose.IsFinite());
      EXPECT_TRUE(kept.insert(pose.stamp).second) << FormatStamp(pose.stamp) << " is there twice";
    }
  }
  for (const FrameResult& result : results) {
    if (!HasPose(result.state)) continue;
    EXPECT_TRUE(result.T_WC.IsFinite()) << FormatStamp(result.stamp);
    if (system.map().NumKeyFramesOf(result.submap) == 0) continue;
    EXPECT_TRUE(kept.contains(result.stamp)) << "no pose is lost but with its submap";
  }
  // Lost frames may be found at the end; there are no poses but of frames.
  for (const FrameResult& result : results) kept.erase(result.stamp);
  EXPECT_TRUE(kept.empty());
  EXPECT_FALSE(system.keyframe_trajectory().empty());
}

// A run in which the readings precede the image.
class FaultRun {
 public:
  explicit FaultRun(unsigned seed)
      : rng_(seed),
        system_({.camera = TinyCamera()}, LightOptions(), {.imu = Walk().calibration}) {}

  void Run(const std::vector<ImuSample>& readings, const std::vector<RgbdImage>& images) {
    std::size_t next = 0;
    for (const RgbdImage& image : images) {
      // Late readings do not delay the ones after them.
      for (; next < readings.size() && readings[next].stamp < image.stamp + FromSeconds(0.1);
           ++next) {
        const ImuSampleStatus status = system_.AddImu(readings[next]);
        const bool refused =
            status == ImuSampleStatus::kNotFinite || status == ImuSampleStatus::kImpossible;
        EXPECT_EQ(refused, !IsPossible(readings[next])) << "said once, where it came in";
      }
      results_.push_back(system_.Track(image));
    }
    system_.Finish();
    (void)EstimateDepthScale(system_.map(), Walk().calibration.T_BC);
    system_.AdjustAll();
    ExpectSound(system_, results_);
  }

  std::mt19937& rng() { return rng_; }
  const std::vector<FrameResult>& results() const { return results_; }
  const SlamSystem& system() const { return system_; }

 private:
  std::mt19937 rng_;
  SlamSystem system_;
  std::vector<FrameResult> results_;
};

// Returns, of each frame with a pose, the difference between its distance from the first frame in
// the estimate and in the truth, ascending.
std::vector<double> Errors(const std::vector<FrameResult>& results) {
  std::vector<double> errors;
  const Trajectory& truth = Walk().truth;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!HasPose(results[i].state)) continue;
    // The map is rotated as a whole once, which does not change lengths.
    const double length = (results[i].T_WC.p() - results[0].T_WC.p()).norm();
    errors.push_back(std::abs(length - (truth[i].pose.p() - truth[0].pose.p()).norm()));
  }
  std::ranges::sort(errors);
  return errors;
}

double WorstError(const std::vector<FrameResult>& results) {
  const std::vector<double> errors = Errors(results);
  return errors.empty() ? 0.0 : errors.back();
}

TEST(SlamFaults, SoundReadingsInitializeTheImuInTime) {
  FaultRun run(1);
  run.Run(Walk().readings, Walk().images);
  EXPECT_EQ(run.results().back().inertial->status, InertialStatus::kRunning)
      << run.results().back().inertial->reason;
  // Images of 160 x 120 pixels leave single frames weak: in nine rooms the worst one is 0.03 to
  // 0.12 m off.
  const std::vector<double> errors = Errors(run.results());
  ASSERT_FALSE(errors.empty());
  EXPECT_LT(errors[errors.size() / 2], 0.03);
  EXPECT_LT(errors.back(), 0.15);
}

TEST(SlamFaults, OfReadingsNeverThrowNorTakeThePoseAway) {
  for (int seed = 0; seed < testing::FaultRuns(20); ++seed) {
    SCOPED_TRACE(seed);
    FaultRun run(static_cast<unsigned>(seed));
    std::vector<ImuSample> readings = Walk().readings;
    const std::set<Fault> faults = testing::InjectSome(run.rng(), readings);
    ASSERT_NO_THROW(run.Run(readings, Walk().images));
    // The images are valid and constrain the pose. Spikes within the range of a sensor are trusted:
    // three of 400 g change the velocity by 20 m/s each, and the pose by that times a tenth of a
    // second.
    EXPECT_LT(WorstError(run.results()), faults.contains(Fault::kSpike) ? 6.0 : 0.3);
    for (const FrameResult& result : run.results()) EXPECT_TRUE(HasPose(result.state));
  }
}

TEST(SlamFaults, OfReadingsAndImagesNeverThrow) {
  for (int seed = 0; seed < testing::FaultRuns(20); ++seed) {
    SCOPED_TRACE(seed);
    FaultRun run(100'000U + static_cast<unsigned>(seed));
    std::vector<ImuSample> readings = Walk().readings;
    std::vector<RgbdImage> images = Walk().images;
    if (Uniform(run.rng(), 0, 1) == 0) testing::InjectSome(run.rng(), readings);
    for (int i = 0, end = Uniform(run.rng(), 1, 4); i < end; ++i) SpoilImage(run.rng(), images);
    for (int i = 0, end = Uniform(run.rng(), 0, 3); i < end; ++i) {
      images.erase(images.begin() + Uniform(run.rng(), 1, static_cast<int>(images.size()) - 1));
    }
    ASSERT_NO_THROW(run.Run(readings, images));
  }
}

}  // namespace
}  // namespace highwall::slam_faults_test
