#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::info_depth_test {
namespace {

using nlohmann::json;
using testing::Outcome;
using testing::TemporaryDirectory;
using testing::WriteText;

constexpr const char* kCamera =
    "camera: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5}\n";

// Tests the report of highwall info on a folder whose images identify their sensor.
class InfoDepthTest : public ::testing::Test {
 protected:
  const std::filesystem::path& dataset() const { return folder_.path(); }

  // Writes eight frames of four walls at 0.8 to 2.5 m. The sensor measures depth from disparities
  // of scale / z [px] in steps of `step` px, and stores it in millimetres times `times`. repeated:
  // number of repeated colour images.
  void Write(double scale, double step, int times, int repeated = 0) const {
    constexpr int kFrames = 8;
    std::filesystem::create_directories(dataset() / "rgb");
    std::filesystem::create_directories(dataset() / "depth");
    std::mt19937 rng(3);
    std::normal_distribution<double> normal;
    std::string rgb, depth;
    cv::Mat colour(120, 160, CV_8UC3), raw(120, 160, CV_16UC1);
    for (int i = 0; i < kFrames; ++i) {
      if (i == 0 || i > repeated) cv::randu(colour, 0, 255);
      for (int v = 0; v < raw.rows; ++v) {
        for (int u = 0; u < raw.cols; ++u) {
          const double z = 1.0 / (1.2 - 0.2 * (u / 40) - 0.15 * v / 120.0 + 0.01 * i);
          const double steps = std::round(scale / (z * step) + normal(rng));
          raw.at<std::uint16_t>(v, u) =
              static_cast<std::uint16_t>(times * std::lround(1000.0 * scale / (steps * step)));
        }
      }
      raw.colRange(0, 10).setTo(0);
      const std::string file = testing::FrameName(i) + ".png";
      cv::imwrite((dataset() / "rgb" / file).string(), colour);
      cv::imwrite((dataset() / "depth" / file).string(), raw);
      rgb += "100." + std::to_string(i) + "00 rgb/" + file + "\n";
      depth += "100." + std::to_string(i) + "00 depth/" + file + "\n";
    }
    WriteText(dataset() / "rgb.txt", rgb);
    WriteText(dataset() / "depth.txt", depth);
  }
  void WriteD435(int repeated = 0) const { Write(642.0 * 0.05, 1.0 / 32.0, 1, repeated); }
  void WriteKinect() const { Write(580.0 * 0.075, 1.0 / 8.0, 5); }

  static json Info(const std::filesystem::path& dataset) {
    const Outcome run =
        testing::RunProgram(testing::kHighwallProgram, "info --json " + dataset.string());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  }
  json Info() const { return Info(dataset()); }

 private:
  TemporaryDirectory folder_;
};

// Returns the sensor and the factor that fit best.
std::string Sensor(const json& info) {
  const json& best = info["depth_image"]["guesses"][0];
  return best["sensor"].get<std::string>() + " " +
         std::to_string(std::lround(best["depth_factor"].get<double>()));
}

std::string Problems(const json& info) {
  return info["problems"].dump();
}

TEST_F(InfoDepthTest, NamesTheSensorAndItsDepthFactorWithoutACalibration) {
  WriteD435();
  json info = Info();
  EXPECT_EQ(Sensor(info), "d435 1000");
  EXPECT_EQ(info["depth_factor"], 1000.0);
  EXPECT_NEAR(info["median_depth"], 1.2, 0.3);
  EXPECT_EQ(info["calibration"]["confidence"], "none");
  EXPECT_NE(info["calibration"]["reason"].get<std::string>().find("sensor: d435"),
            std::string::npos);
  WriteKinect();
  info = Info();
  EXPECT_EQ(Sensor(info), "kinect1 5000");
  EXPECT_EQ(info["depth_factor"], 5000.0);
}

TEST_F(InfoDepthTest, WarnsWhereTheDepthFactorGivenDoesNotFit) {
  WriteD435();
  const std::string head = std::string(kCamera);
  WriteText(dataset() / "calibration.yaml", head + "depth_factor: 5000\n");
  EXPECT_NE(Problems(Info()).find("the depth looks like d435 with depth factor 1000, but the "
                                  "calibration says 5000"),
            std::string::npos)
      << Problems(Info());
  WriteText(dataset() / "calibration.yaml", head + "sensor: d435\n");
  EXPECT_EQ(Problems(Info()), "[]");
}

TEST_F(InfoDepthTest, WarnsWhereTheRangeGivenDoesNotFit) {
  WriteD435();
  WriteText(dataset() / "calibration.yaml",
            std::string(kCamera) + "depth_factor: 1000\ndepth_range: {max: 1.2}\n");
  EXPECT_NE(Problems(Info()).find("0.05 to 1.2 m, the range of the sensor"), std::string::npos);
}

TEST_F(InfoDepthTest, WarnsWhereTheDepthIsFarNoisierThanGiven) {
  WriteD435();
  WriteText(dataset() / "calibration.yaml",
            std::string(kCamera) +
                "depth_factor: 1000\n"
                "depth_noise: {offset: 0.0001, quadratic: 0, reference: 0}\n");
  EXPECT_NE(Problems(Info()).find("twice as noisy"), std::string::npos);
}

TEST_F(InfoDepthTest, CountsColourImagesThatRepeat) {
  WriteD435(3);
  const json info = Info();
  EXPECT_EQ(info["repeated_colour"], 3);
  EXPECT_NE(Problems(info).find("3 colour images repeat the one before"), std::string::npos);
}

// It looks at more than eight images where slam does: at those around them.
TEST_F(InfoDepthTest, WarnsOfDepthOfAnotherMoment) {
  constexpr int kFrames = 64, kPan = 4, kLate = 3;  // pan: [px] a frame, first to the right
  std::mt19937 rng(5);
  std::uniform_int_distribution<int> u(0, 140), v(0, 100), side(12, 30), value(0, 255);
  cv::Mat colour(120, 160, CV_8UC3, cv::Scalar::all(90)), raw(120, 160, CV_16UC1, 3000);
  for (int i = 0; i < 12; ++i) {
    cv::Rect box;
    box.x = u(rng);
    box.y = v(rng);
    box.width = side(rng);
    box.height = side(rng);
    box &= cv::Rect(0, 0, 160, 120);
    const int grey = value(rng);
    colour(box).setTo(cv::Scalar::all(grey));
    raw(box).setTo(800 + 5 * value(rng));
  }
  cv::Mat noise(raw.size(), CV_16UC1);
  cv::randu(noise, 0, 40);
  raw += noise;
  const auto moved = [](const cv::Mat& image, int frame) {  // in a ring
    const int by = 8 * image.cols + kPan * (frame < kFrames / 2 ? frame : kFrames - frame);
    cv::Mat twice;
    cv::hconcat(image, image, twice);
    return twice.colRange(image.cols - by % image.cols, 2 * image.cols - by % image.cols).clone();
  };
  std::filesystem::create_directories(dataset() / "rgb");
  std::filesystem::create_directories(dataset() / "depth");
  std::string rgb, depth;
  for (int i = 0; i < kFrames; ++i) {
    const std::string file = testing::FrameName(i) + ".png";
    cv::imwrite((dataset() / "rgb" / file).string(), moved(colour, i));
    cv::imwrite((dataset() / "depth" / file).string(), moved(raw, i - kLate));
    const std::string stamp = std::to_string(100.0 + i / 30.0);
    rgb += stamp + " rgb/" + file + "\n";
    depth += stamp + " depth/" + file + "\n";
  }
  WriteText(dataset() / "rgb.txt", rgb);
  WriteText(dataset() / "depth.txt", depth);
  WriteText(dataset() / "calibration.yaml", std::string(kCamera) + "depth_factor: 1000\n");
  EXPECT_NE(Problems(Info()).find("ms before the colour it is paired with"), std::string::npos)
      << Problems(Info());
}

TEST_F(InfoDepthTest, NamesTheSensorsOfRealRecordings) {
  const std::filesystem::path shared = testing::kSharedData;
  const std::filesystem::path d435 = shared / "d435_desk";
  if (!std::filesystem::exists(d435 / "rgb.txt")) GTEST_SKIP() << d435 << ": no shared/data here";
  const json given = Info(d435);
  EXPECT_EQ(Sensor(given), "d435 1000");
  EXPECT_EQ(given["repeated_colour"], 29);
  for (const char* name : {"rgb", "depth", "rgb.txt", "depth.txt"}) {
    std::filesystem::create_symlink(d435 / name, dataset() / name);
  }
  const json bare = Info();
  EXPECT_EQ(Sensor(bare), "d435 1000");
  EXPECT_EQ(bare["depth_factor"], 1000.0);
  EXPECT_EQ(Sensor(Info(shared / "tum/fr1_xyz")), "kinect1 5000");
  EXPECT_EQ(Sensor(Info(shared / "tum/fr3_teddy_200")), "kinect1 5000");
}

}  // namespace
}  // namespace highwall::info_depth_test
