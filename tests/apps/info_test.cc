#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::info_test {
namespace {

using nlohmann::json;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::Truncate;
using testing::WriteText;
using testing::WriteTum;

// Readings at 200 Hz over the images of WriteTum(): a slow rotation, gravity in units of `unit`
// [m/s^2].
std::string ImuText(double unit = 1.0) {
  std::string text = "#timestamp [ns],wx,wy,wz,ax,ay,az\n";
  for (int i = 0; i <= 120; ++i) {
    text += std::to_string(99'950'000'000 + i * 5'000'000LL) + ",0.1," + std::to_string(1e-4 * i) +
            ",0,0," + std::to_string(1e-3 * i / unit) + "," + std::to_string(9.81 / unit) + "\n";
  }
  return text;
}

// Runs the built executable with its own folder for a dataset.
class InfoTest : public ::testing::Test {
 protected:
  const std::filesystem::path& dataset() const { return folder_.path(); }

  static Outcome Highwall(const std::string& arguments) {
    return testing::RunProgram(testing::kHighwallProgram, arguments);
  }

  Outcome Info(const std::string& options = "") const {
    return Highwall("info " + dataset().string() + " " + options);
  }

  // Returns the output of a run that must succeed and print nothing else.
  json InfoJson() const {
    const Outcome run = Info("--json");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return json::parse(run.out);
  }

  // Expects one line on standard error that contains `part`, and exit code 2.
  void ExpectRefused(const std::string& part) const {
    testing::ExpectRefused(Info("--json"), 2, {part});
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(InfoTest, DescribesAWholeDataset) {
  WriteTum(dataset(), {.frames = 6, .raw_depth = 10000, .textured = true, .depth_step = 5});
  WriteText(dataset() / "groundtruth.txt", "100.0 0 0 0 0 0 0 1\n100.5 3 4 0 0 0 0 1\n");
  WriteText(dataset() / "calibration.yaml",
            "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 32, cy: 24}\n"
            "depth_factor: 5000\nimu: {rate: 200}\n");
  WriteText(dataset() / "imu.csv", ImuText());
  const json info = InfoJson();
  EXPECT_EQ(info["frames"], 6);
  EXPECT_EQ(info["usable_frames"], 6);
  EXPECT_EQ(info["colour"]["count"], 6);
  EXPECT_EQ(info["depth"]["count"], 6);
  EXPECT_EQ(info["width"], 64);
  EXPECT_EQ(info["height"], 48);
  EXPECT_DOUBLE_EQ(info["duration"], 0.5);
  EXPECT_DOUBLE_EQ(info["rate"], 10.0);
  EXPECT_EQ(info["gaps"], 0);
  EXPECT_EQ(info["association_rate"], 1.0);
  EXPECT_EQ(info["depth_factor"], 5000.0);
  EXPECT_EQ(info["median_depth"], 2.0);
  EXPECT_DOUBLE_EQ(info["measured_share"], 63.0 / 64.0);
  EXPECT_EQ(info["groundtruth"]["count"], 2);
  EXPECT_EQ(info["groundtruth"]["path_length"], 5.0);
  EXPECT_EQ(info["groundtruth"]["frames_covered"], 1.0);
  EXPECT_EQ(info["imu"]["count"], 121);
  EXPECT_DOUBLE_EQ(info["imu"]["rate"], 200.0);
  EXPECT_EQ(info["imu"]["file"], "imu.csv");
  EXPECT_EQ(info["imu"]["usable"], true);
  EXPECT_TRUE(info["accelerometer"].is_null());
  EXPECT_EQ(info["calibration"]["confidence"], "given");
  EXPECT_TRUE(info["problems"].empty()) << info["problems"];
}

TEST_F(InfoTest, NamesTheFaultOfTheImu) {
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  WriteText(dataset() / "imu.csv", ImuText(9.80665));
  json info = InfoJson();
  EXPECT_EQ(info["imu"]["usable"], true);
  ASSERT_EQ(info["problems"].size(), 2U) << info["problems"];
  const std::string imu = (dataset() / "imu.csv").string();
  EXPECT_EQ(info["problems"][0],
            imu + ": accelerometer: the median norm is 1: it is in g, not in m/s^2; converted");
  EXPECT_EQ(info["problems"][1].get<std::string>().find(imu + ": the IMU is not calibrated"), 0U);

  WriteText(dataset() / "imu.csv", ImuText(8.0));
  info = InfoJson();
  EXPECT_EQ(info["imu"]["usable"], false);
  EXPECT_EQ(info["problems"][0],
            imu +
                ": accelerometer: the median norm is 1.23: it is likely in g, not in m/s^2; "
                "multiply by 9.80665; the IMU is not used");
  EXPECT_NE(Info().out.find("IMU           imu.csv: 121 in 0.6 s, 200.0/s; cannot be used"),
            std::string::npos);

  WriteText(dataset() / "imu.csv", "99900000000,0,0,0,0,0\n");
  info = InfoJson();
  EXPECT_EQ(info["imu"]["usable"], false);
  EXPECT_EQ(info["problems"][0].get<std::string>().find(imu + ":1: has 6 fields"), 0U);
}

TEST_F(InfoTest, NamesABadGroundTruthAmongTheProblems) {
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  WriteText(dataset() / "groundtruth.txt", "100.0 0 0 0 0 0 0 1\n100.0,1,0,0,0,0,0,1\n");
  const json info = InfoJson();
  EXPECT_TRUE(info["groundtruth"].is_null());
  ASSERT_EQ(info["problems"].size(), 1U) << info["problems"];
  const std::string truth = (dataset() / "groundtruth.txt").string();
  EXPECT_EQ(info["problems"][0].get<std::string>().find(truth + ":2: "), 0U);
}

TEST_F(InfoTest, SeesThatImagesAreBlackOrPlain) {
  WriteTum(dataset(), {.depth_step = 5});  // three grey levels at most
  json info = InfoJson();
  EXPECT_EQ(info["dark_colour"], 6);
  EXPECT_EQ(info["plain_colour"], 0);
  ASSERT_EQ(info["problems"].size(), 1U) << info["problems"];
  EXPECT_EQ(info["problems"][0].get<std::string>().find(
                "6 of 6 colour images are black or too dark to find features in"),
            0U);

  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  info = InfoJson();
  EXPECT_EQ(info["dark_colour"], 0);
  EXPECT_TRUE(info["problems"].empty()) << info["problems"];
  // A wall with camera noise.
  cv::Mat wall(48, 64, CV_8UC3);
  for (const int frame : {2, 3, 4}) {
    cv::RNG(7).fill(wall, cv::RNG::NORMAL, 120 + frame, 2);
    cv::imwrite((dataset() / "rgb" / (testing::FrameName(frame) + ".png")).string(), wall);
  }
  info = InfoJson();
  EXPECT_EQ(info["dark_colour"], 0);
  EXPECT_EQ(info["plain_colour"], 3);
  ASSERT_EQ(info["problems"].size(), 1U) << info["problems"];
  EXPECT_EQ(
      info["problems"][0].get<std::string>().find("3 of 6 colour images show hardly any texture"),
      0U);
}

TEST_F(InfoTest, PrintsTextForPeople) {
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  const Outcome run = Info();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("frames        6 in 0.5 s, 10.0/s; 6 usable, 64 x 48"), std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("no problems found"), std::string::npos) << run.out;
}

TEST_F(InfoTest, CountsAndNamesUnreadableFilesAndContinues) {
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  Truncate(dataset() / "rgb/102.png");
  std::filesystem::remove(dataset() / "depth/104.png");
  const json info = InfoJson();
  EXPECT_EQ(info["frames"], 6);
  EXPECT_EQ(info["usable_frames"], 4);
  EXPECT_EQ(info["calibration"]["confidence"], "none");
  ASSERT_EQ(info["problems"].size(), 2U);
  EXPECT_EQ(info["problems"][0], (dataset() / "rgb/102.png").string() + ": is truncated");
  EXPECT_NE(info["problems"][1].get<std::string>().find("depth/104.png: cannot be read"),
            std::string::npos);
}

TEST_F(InfoTest, ReportsGapsAndStampsWithoutAPartner) {
  WriteTum(dataset(), {.frames = 5, .textured = true, .depth_step = 5});
  std::string rgb, depth;
  int image = 100;
  for (const char* stamp : {"10.0", "10.1", "10.2", "11.0", "11.1"}) {
    rgb += std::string(stamp) + " rgb/" + std::to_string(image) + ".png\n";
    depth += std::string(stamp) + " depth/" + std::to_string(image++) + ".png\n";
  }
  WriteText(dataset() / "rgb.txt", rgb + "11.2 rgb/101.png\n");
  WriteText(dataset() / "depth.txt", depth + "11.25 depth/101.png\n11.3 depth/102.png\n");
  const json info = InfoJson();
  EXPECT_EQ(info["gaps"], 1);
  EXPECT_DOUBLE_EQ(info["longest_interval"], 0.8);
  EXPECT_DOUBLE_EQ(info["association_rate"], 5.0 / 6.0);
  ASSERT_EQ(info["problems"].size(), 2U) << info["problems"];
  EXPECT_EQ(info["problems"][0], "1 colour and 2 depth images have no partner within 20 ms");
  EXPECT_EQ(info["problems"][1], "1 gap between frames, the longest of 0.800 s at 10.200000");
}

TEST_F(InfoTest, SuspectsTheDepthFactorAndNamesTheLikelyOne) {
  WriteTum(dataset(), {.raw_depth = 400,
                       .textured = true,
                       .depth_step = 5});  // 0.08 m at the usual 5000, 0.4 m in millimetres
  const json info = InfoJson();
  ASSERT_EQ(info["problems"].size(), 1U);
  EXPECT_NE(info["problems"][0].get<std::string>().find("the factor is likely 1000"),
            std::string::npos);
}

TEST_F(InfoTest, SaysHowSureItIsOfTheCalibration) {
  WriteTum(dataset(),
           {.frames = 1, .width = 640, .height = 480, .textured = true, .depth_step = 5});
  json info = InfoJson();
  EXPECT_EQ(info["calibration"]["name"], "tum3");
  EXPECT_EQ(info["calibration"]["confidence"], "unsure");
  const std::string list = ReadText(dataset() / "rgb.txt");
  WriteText(dataset() / "rgb.txt", "# file: 'rgbd_dataset_freiburg1_xyz.bag'\n" + list);
  info = InfoJson();
  EXPECT_EQ(info["calibration"]["name"], "tum1");
  EXPECT_EQ(info["calibration"]["confidence"], "certain");
  WriteText(dataset() / "calibration.yaml",
            "camera: {width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240}\n"
            "depth_factor: 1000\n");
  info = InfoJson();
  EXPECT_EQ(info["calibration"]["confidence"], "given");
  EXPECT_EQ(info["depth_factor"], 1000.0);
}

TEST_F(InfoTest, ReportsACalibrationForAnotherImageSize) {
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  WriteText(dataset() / "calibration.yaml",
            "camera: {width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240}\n"
            "depth_factor: 5000\n");
  const json info = InfoJson();
  ASSERT_EQ(info["problems"].size(), 1U) << info["problems"];
  EXPECT_EQ(info["problems"][0], "images are 64 x 48, but the calibration is for 640 x 480");
}

TEST_F(InfoTest, RefusesBadInputWithOneLineAndExitCodeTwo) {
  ExpectRefused(dataset().string() + ": is empty");
  WriteTum(dataset(), {.textured = true, .depth_step = 5});
  const std::string list = ReadText(dataset() / "rgb.txt");
  std::filesystem::remove(dataset() / "rgb.txt");
  ExpectRefused("rgb.txt: is missing");
  WriteText(dataset() / "rgb.txt", "nonsense\n");
  ExpectRefused("rgb.txt:1: 'nonsense' is not a time stamp");
  WriteText(dataset() / "rgb.txt", "7.0 rgb/100.png\n");
  ExpectRefused("no stamp of rgb.txt has one of depth.txt");
  WriteText(dataset() / "rgb.txt", list);
  WriteText(dataset() / "calibration.yaml", "depth_facter: 5000\n");
  ExpectRefused("calibration.yaml:1: unknown key 'depth_facter'; did you mean 'depth_factor'?");
}

TEST_F(InfoTest, RefusesADatasetWithoutAnyUsableFrame) {
  WriteTum(dataset(), {.raw_depth = 0});
  ExpectRefused("none of its 6 frames can be used");
}

TEST_F(InfoTest, ExitsWithOneForWrongUsageAndZeroForHelp) {
  EXPECT_EQ(Highwall("info").exit_code, 1);
  EXPECT_EQ(Info("--jsn").exit_code, 1);
  const Outcome help = Highwall("info --help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("Example"), std::string::npos);
}

TEST_F(InfoTest, RefusesARecordingOfEurocBeforeItReadsIt) {
  // Neither this file nor the missing ones are named.
  std::filesystem::create_directories(dataset() / "mav0" / "cam0");
  WriteText(dataset() / "mav0" / "cam0" / "sensor.yaml", "no calibration");
  testing::ExpectRefused(Info(), 2, {dataset().string(), "EuRoC", "highwall slam does"});
  WriteText(dataset() / "calibration.yaml", "no calibration");
  testing::ExpectRefused(Info(), 2, {"EuRoC", "highwall slam does"});
}

}  // namespace
}  // namespace highwall::info_test
