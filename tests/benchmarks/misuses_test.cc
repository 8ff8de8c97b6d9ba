// Each wrong statement of a recording has the effect that its name states.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "misuses.h"
#include "stated_recording.h"
#include "trial.h"
#include "true_recording.h"

namespace highwall::bench::misuses_test {
namespace {

constexpr std::size_t kFrames = 40;
constexpr Stamp kInterval = 33'000'000;  // [ns]

// Depth is 2 m on the left and 1 m plus a millimetre per frame on the right; the first column has
// none, and the first rows have 3 m.
class Walls final : public Dataset {
 public:
  Walls() {
    for (std::size_t i = 0; i < kFrames; ++i) {
      truth_.push_back({stamp(i), Pose()});
      cv::Mat depth(48, 64, CV_32FC1, cv::Scalar(2.0));
      depth.colRange(32, 64).setTo(1.0 + 1e-3 * static_cast<double>(i));
      depth.rowRange(0, 6).setTo(3.0);
      depth.col(0).setTo(0.0);
      cv::Mat colour(48, 64, CV_8UC3, cv::Scalar::all(100));
      colour(cv::Rect(0, 0, 10, 10)).setTo(0);  // a corner that no flip leaves where it is
      images_.push_back({stamp(i), colour, depth});
    }
  }
  std::size_t size() const override { return kFrames; }
  Stamp stamp(std::size_t index) const override {
    return 1'000'000'000 + static_cast<Stamp>(index) * kInterval;
  }
  const Trajectory* groundtruth() const override { return &truth_; }

 private:
  RgbdImage DoLoad(std::size_t index) const override { return images_.at(index); }

  std::vector<RgbdImage> images_;
  Trajectory truth_;
};

TrueRecording Recording() {
  TrueRecording recording{
      .name = "walls", .images = std::make_shared<Walls>(), .sensor = {}, .imu = apps::ImuFeed{}};
  recording.sensor.camera = {64, 48, 52.5, 52.5, 31.5, 23.5};
  recording.imu->calibration.T_BC =
      Pose(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d(0.01, 0.02, 0.03));
  for (int i = 0; i < 600; ++i) {
    const double t = 0.005 * i;
    recording.imu->samples.push_back({1'000'000'000 + Stamp{i} * 5'000'000,
                                      {1.0 + t, 2.0 + t, 3.0 + t},
                                      {4.0 + t, 5.0 + t, 9.0 + t}});
  }
  return recording;
}

const Misuse& Named(const std::vector<Misuse>& misuses, const std::string& name) {
  return *std::ranges::find(misuses, name, NameOf);
}

float DepthOf(const std::string& misuse, int u, int v = 20, std::size_t frame = 20) {
  const TrueRecording recording = Recording();
  const StatedSequence sequence = Misstate(recording, Named(DepthMisuses(), misuse));
  return sequence.Load(frame)->depth.at<float>(v, u);
}

TEST(Misuses, AreFortyFaultsWithANameOfTheirOwnAtEachStrength) {
  EXPECT_GE(AllFaults().size(), 40U);
  std::set<std::string> names;
  for (const Misuse& misuse : AllMisuses()) {
    EXPECT_TRUE(names.insert(NameOf(misuse)).second) << NameOf(misuse);
    EXPECT_FALSE(misuse.expected.empty()) << NameOf(misuse);
  }
}

TEST(Misuses, EachChangesImagesOrSensorsAndTheTruthIsByteEqual) {
  const TrueRecording recording = Recording();
  const StatedSequence truth(recording, TruthOf(recording));
  EXPECT_EQ(cv::norm(truth.Load(20)->depth, recording.images->Load(20)->depth, cv::NORM_INF), 0.0);
  for (const Misuse& misuse : AllMisuses()) {
    SCOPED_TRACE(NameOf(misuse));
    const StatedSequence stated = Misstate(recording, misuse);
    EXPECT_EQ(stated.stated().imu.has_value(), misuse.inertial);
    bool differs = false;
    for (std::size_t i = 0; i < kFrames; ++i) {
      const RgbdImage a = *stated.Load(i), b = *truth.Load(i);
      differs |= a.stamp != b.stamp || a.depth_stamp != b.depth_stamp ||
                 cv::norm(a.depth, b.depth, cv::NORM_INF) > 0.0;
      differs |= cv::norm(a.bgr, b.bgr, cv::NORM_INF) > 0.0;
    }
    const PinholeCamera &lens = stated.stated().sensor.camera, &right = recording.sensor.camera;
    differs |= lens.fx != right.fx || lens.fy != right.fy || lens.cx != right.cx ||
               lens.cy != right.cy || lens.k1 != right.k1;
    if (misuse.inertial) {
      const apps::ImuFeed &imu = *stated.stated().imu, &before = *recording.imu;
      differs |= imu.samples.size() != before.samples.size() ||
                 !imu.calibration.T_BC.Matrix().isApprox(before.calibration.T_BC.Matrix());
      for (std::size_t i = 0; !differs && i < imu.samples.size(); ++i) {
        differs = imu.samples[i].stamp != before.samples[i].stamp ||
                  imu.samples[i].gyroscope != before.samples[i].gyroscope ||
                  imu.samples[i].accelerometer != before.samples[i].accelerometer;
      }
    }
    EXPECT_TRUE(differs);
    EXPECT_EQ(recording.images->Load(20)->depth.at<float>(20, 10), 2.0F) << "the truth stays";
  }
}

TEST(DepthMisuses, HaveTheDepthThatTheyState) {
  EXPECT_FLOAT_EQ(DepthOf("depth factor x 5", 10), 0.4F);
  EXPECT_FLOAT_EQ(DepthOf("constant depth 2 m", 50), 2.0F);
  EXPECT_FLOAT_EQ(DepthOf("constant depth of the first image", 50), 1.0F);
  EXPECT_FLOAT_EQ(DepthOf("saturated depth 65535", 0), 65535 / 5000.0F);
  EXPECT_FLOAT_EQ(DepthOf("saturated depth 65535", 10), 2.0F);
  EXPECT_FLOAT_EQ(DepthOf("swapped bytes", 10), 0x1027 / 5000.0F);  // of 10000 = 0x2710
  EXPECT_FLOAT_EQ(DepthOf("inverse depth 1 m at 1 m", 10), 0.5F);
  EXPECT_FLOAT_EQ(DepthOf("mirrored depth left to right", 50), 2.0F);
  EXPECT_FLOAT_EQ(DepthOf("shifted depth 32 px", 34), 2.0F) << "3 px of 64";
  EXPECT_FLOAT_EQ(DepthOf("shifted depth 32 px", 36), 1.02F);
  EXPECT_FLOAT_EQ(DepthOf("depth of 10 bits cut to 1023", 10), 1023 / 5000.0F);
  EXPECT_FLOAT_EQ(DepthOf("depth of 10 bits without the lowest 6", 10), (10000 >> 6) / 5000.0F);
  // Stored in steps of 0.2 mm.
  EXPECT_NEAR(DepthOf("late depth 100 ms", 50), 1.017F, 1e-4F);
  EXPECT_FLOAT_EQ(DepthOf("narrow depth 0.5 of the view", 0), 2.0F) << "what was at a quarter";
}

TEST(ImuMisuses, ReadingsOfAnotherRecordingHaveTheStampsOfThisOne) {
  const TrueRecording recording = Recording();
  const StatedSequence other =
      Misstate(recording, Named(ImuMisuses(), "IMU of another recording backwards"));
  const std::vector<ImuSample>&samples = other.stated().imu->samples,
        &right = recording.imu->samples;
  ASSERT_EQ(samples.size(), right.size());
  EXPECT_EQ(samples.front().stamp, right.front().stamp);
  EXPECT_EQ(samples.front().gyroscope, right.back().gyroscope);
}

TEST(StampMisuses, HaveTheStampsThatTheyState) {
  const TrueRecording recording = Recording();
  const auto stamp = [&](const std::string& misuse, std::size_t frame) {
    return Misstate(recording, Named(StampMisuses(), misuse)).stamp(frame);
  };
  EXPECT_EQ(stamp("frame numbers from 0", 7), 7'000'000'000);
  EXPECT_EQ(stamp("unit of stamps milliseconds", 2), 66'000'000'000);
  EXPECT_EQ(stamp("equal stamps one in 10", 9), stamp("equal stamps one in 10", 8));
  EXPECT_GT(stamp("decreasing stamps all", 0), stamp("decreasing stamps all", 1));
  EXPECT_EQ(stamp("stamps of arrival 3 at a time", 0), 1'066'000'000 - 2'000'000);
}

TEST(StatedSequence, PosesReturnToTheStampsOfTheTruth) {
  const TrueRecording recording = Recording();
  const StatedSequence numbers = Misstate(recording, Named(StampMisuses(), "frame numbers from 1"));
  const Trajectory restored = numbers.AtTrueStamps({{numbers.stamp(3), Pose()}});
  EXPECT_EQ(restored.front().stamp, recording.images->stamp(3));
}

}  // namespace
}  // namespace highwall::bench::misuses_test
