// docs/examples/network_points.h with a network of two convolutions: bright spots are points, and
// the surroundings of a cell are its descriptor.
#include "network_points.h"

#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <highwall/frontend/system/slam_system.h>

#include "onnx_file.h"
#include "support/message_of.h"
#include "support/run_program.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::network_points_test {
namespace {

constexpr int kCell = 8, kDescriptor = 64;

// Returns the response of a spot of 3 x 3 pixels against the ring of two pixels around it, for each
// pixel of a cell.
testing::OnnxConvolution Scores() {
  constexpr int kReach = 3, kSide = kCell + 2 * kReach;
  testing::OnnxConvolution scores{.output = "scores",
                                  .channels = kCell * kCell + 1,
                                  .side = kSide,
                                  .stride = kCell,
                                  .padding = kReach,
                                  .weights = {},
                                  .bias = {}};
  for (int c = 0; c < kCell * kCell; ++c) {
    const int row = kReach + c / kCell, column = kReach + c % kCell;
    for (int v = 0; v < kSide; ++v) {
      for (int u = 0; u < kSide; ++u) {
        const int r = std::max(std::abs(v - row), std::abs(u - column));
        const float ring = -1.0F / 40.0F, spot = 1.0F / 9.0F;
        scores.weights.push_back(30.0F * (r <= 1 ? spot : r <= kReach ? ring : 0.0F));
      }
    }
    scores.bias.push_back(0.0F);
  }
  scores.weights.insert(scores.weights.end(), kSide * kSide, 0.0F);
  scores.bias.push_back(6.0F);  // no point
  return scores;
}

testing::OnnxConvolution Descriptors() {
  constexpr int kReach = 8, kSide = kCell + 2 * kReach;
  testing::OnnxConvolution descriptors{.output = "descriptors",
                                       .channels = kDescriptor,
                                       .side = kSide,
                                       .stride = kCell,
                                       .padding = kReach,
                                       .weights = {},
                                       .bias = std::vector<float>(kDescriptor, 0.0F)};
  for (int c = 0; c < kDescriptor; ++c) {
    cv::Mat kernel(kSide, kSide, CV_32F);
    cv::RNG(static_cast<std::uint64_t>(c + 1)).fill(kernel, cv::RNG::NORMAL, 0.0, 1.0);
    cv::GaussianBlur(kernel, kernel, {}, 2.0);
    kernel -= cv::mean(kernel);
    descriptors.weights.insert(descriptors.weights.end(), kernel.begin<float>(),
                               kernel.end<float>());
  }
  return descriptors;
}

class NetworkPointsTest : public ::testing::Test {
 protected:
  std::filesystem::path Network(const std::vector<testing::OnnxConvolution>& outputs) const {
    const auto path = folder_.path() / "points.onnx";
    testing::WriteText(path, testing::OnnxFile(outputs, 64, 64));
    return path;
  }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(NetworkPointsTest, PointsAreThePeaksOfTheHeatMap) {
  NetworkPoints points(Network({Descriptors(), Scores()}));
  EXPECT_EQ(points.kind().columns, kDescriptor);
  cv::Mat image(60, 90, CV_8UC1, cv::Scalar(50));  // no multiples of 8
  const cv::Point spots[] = {{20, 30}, {47, 16}, {71, 45}};
  for (const cv::Point& spot : spots) {
    image(cv::Rect(spot.x - 1, spot.y - 1, 3, 3)).setTo(220);
  }
  const ExtractedPoints found = points.Extract(image);
  ASSERT_EQ(found.keypoints.size(), 3U);
  EXPECT_EQ(found.descriptors.size(), cv::Size(kDescriptor, 3));
  for (const cv::Point& spot : spots) {
    EXPECT_TRUE(std::ranges::any_of(found.keypoints, [&](const cv::KeyPoint& k) {
      return cv::norm(k.pt - cv::Point2f(spot)) < 0.05;
    })) << spot;
  }
  for (const cv::KeyPoint& k : found.keypoints) EXPECT_LT(k.angle, 0.0F);
}

// The camera moves to the right in front of a wall with spots, by cells of the network.
TEST_F(NetworkPointsTest, AreTrackedAndMapped) {
  const RgbdSensor sensor{
      .camera = {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5}};
  constexpr double kDepth = 2.0;  // [m]
  constexpr int kSteps = 6;
  cv::Mat wall(240, 320 + kSteps * kCell, CV_8UC3);
  cv::RNG(3).fill(wall, cv::RNG::UNIFORM, 0, 160);
  cv::GaussianBlur(wall, wall, {}, 3.0);
  std::mt19937 rng(2);
  for (int i = 0; i < 350; ++i) {
    const cv::Point spot(static_cast<int>(rng() % static_cast<unsigned>(wall.cols)),
                         static_cast<int>(rng() % static_cast<unsigned>(wall.rows)));
    wall(cv::Rect(spot.x - 1, spot.y - 1, 3, 3) & cv::Rect({}, wall.size()))
        .setTo(cv::Scalar::all(180.0 + static_cast<double>(rng() % 70)));
  }
  SlamOptions options = Deterministic({});
  options.frame.use_lines = false;
  SlamSystem slam(sensor, options,
                  {.points = std::make_shared<NetworkPoints>(Network({Scores(), Descriptors()}))});
  for (int step = 0; step <= kSteps; ++step) {
    const FrameResult frame =
        slam.Track({step * 33'000'000, wall(cv::Rect(step * kCell, 0, 320, 240)).clone(),
                    cv::Mat(240, 320, CV_32FC1, cv::Scalar(kDepth))});
    ASSERT_EQ(frame.state, TrackingState::kTracking) << step;
    const Eigen::Vector3d truth(0.0, -step * kCell * kDepth / sensor.camera.fx, 0.0);
    EXPECT_LT((frame.T_WC.p() - truth).norm(), 1e-3) << step;
    if (step == 0) continue;  // there is no map yet
    EXPECT_GT(frame.matched_points, 100) << step;
  }
  EXPECT_EQ(slam.map().feature_type().name, "network");
}

TEST_F(NetworkPointsTest, AFileThatIsNoSuchNetworkIsRefusedByName) {
  const testing::TemporaryDirectory folder("other");
  const auto refused = [](const std::filesystem::path& path) {
    return testing::MessageOf<IoError>([&] { NetworkPoints points(path); });
  };
  testing::WriteText(folder.path() / "text.onnx", "no network");
  EXPECT_TRUE(refused(folder.path() / "text.onnx")
                  .ends_with("text.onnx: cannot be read as a network in ONNX"));
  EXPECT_TRUE(refused(folder.path() / "none.onnx")
                  .ends_with("none.onnx: cannot be read as a network in ONNX"));
  const std::string message = refused(Network({Descriptors()}));
  EXPECT_TRUE(
      message.ends_with("points.onnx: has not two outputs, of 65 scores and a descriptor "
                        "for each cell of 8 x 8 pixels"))
      << message;
}

TEST_F(NetworkPointsTest, TheProgramOfTheExampleSaysWhatItWantsAndWhatIsWrong) {
  const testing::Outcome usage = testing::RunProgram(testing::kNetworkPointsExample, "");
  EXPECT_EQ(usage.exit_code, 1);
  EXPECT_TRUE(testing::Contains(usage.err, "usage: network_points tum1|tum2|tum3"));
  const testing::Outcome wrong =
      testing::RunProgram(testing::kNetworkPointsExample, "tum1 d none.onnx out.txt");
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_TRUE(testing::Contains(wrong.err, "none.onnx: cannot be read")) << wrong.err;
}

}  // namespace
}  // namespace highwall::network_points_test
