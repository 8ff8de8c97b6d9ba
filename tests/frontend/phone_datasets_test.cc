// Recordings of iPhones: Stray Scanner and 3D Scanner App.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>

#include "input/phone_recording.h"
#include "input/scanner_app_dataset.h"
#include "input/stray_scanner_dataset.h"
#include "support/message_of.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::phone_datasets_test {
namespace {

namespace fs = std::filesystem;
using testing::MessageOf;
using testing::TemporaryDirectory;
using testing::WriteText;

std::string SixDigits(int number) {
  const std::string digits = std::to_string(number);
  return std::string(6 - digits.size(), '0') + digits;
}

cv::Mat RandomColour(const cv::Size& size, int seed) {
  cv::Mat image(size, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// [mm] 1 to 4 m; one pixel is full.
cv::Mat RandomDepth(const cv::Size& size, int seed) {
  cv::Mat image(size, CV_16UC1);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 1000, 4000);
  image.at<std::uint16_t>(0, 0) = UINT16_MAX;
  return image;
}

// 0, 1 and 2 by columns.
cv::Mat Confidence(const cv::Size& size) {
  cv::Mat image(size, CV_8UC1);
  for (int u = 0; u < size.width; ++u) image.col(u).setTo(u % 3);
  return image;
}

void WriteImage(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(cv::imwrite(path.string(), image));
}

constexpr const char* kStrayHeading = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";

// Four frames at 100.0 s and each 0.5 s, without images; the third has no depth.
void WriteStray(const fs::path& folder) {
  const cv::Size size(16, 12);
  std::string odometry = kStrayHeading;
  for (int i = 0; i < 4; ++i) {
    odometry += std::to_string(100 + i / 2) + (i % 2 == 0 ? ".0" : ".5") + ", " + SixDigits(i) +
                ", " + std::to_string(i) + ", 2, 3, 0.0, 0.0, 0.6, 0.8\n";
    if (i == 2) continue;
    WriteImage(folder / "depth" / (SixDigits(i) + ".png"), RandomDepth(size, i));
    WriteImage(folder / "confidence" / (SixDigits(i) + ".png"), Confidence(size));
  }
  WriteText(folder / "odometry.csv", odometry);
  WriteText(folder / "camera_matrix.csv", "1350.0, 0.0, 962.0\n0.0, 1350.0, 722.0\n0.0, 0.0, 1.0");
  WriteText(folder / "imu.csv",
            "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n"
            "100.25, -9.8, 0.5, 0.25, 0.1, 0.2, 0.3\n100.26, -9.8, 0.5, 0.25, 0.1, 0.2, 0.3\n");
}

void WriteStrayImages(const fs::path& folder, const cv::Size& size) {
  for (int i = 0; i < 4; ++i) {
    WriteImage(folder / "rgb" / (SixDigits(i) + ".png"), RandomColour(size, i));
  }
}

TEST(StrayScanner, ReadsImagesDepthAndConfidencePixelByPixel) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  const auto dataset = OpenDataset(folder.path());
  ASSERT_NE(dynamic_cast<const StrayScannerDataset*>(dataset.get()), nullptr);
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->stamp(2), 101'500'000'000);
  EXPECT_EQ(dataset->stamps_without_depth(), std::vector<Stamp>{101'000'000'000});
  EXPECT_TRUE(dataset->warnings().empty());
  const auto image = dataset->Load(2);
  ASSERT_TRUE(image);
  EXPECT_EQ(cv::norm(image->bgr, RandomColour({64, 48}, 3), cv::NORM_INF), 0.0);
  const cv::Mat raw = RandomDepth({16, 12}, 3);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const std::uint16_t stored = raw.at<std::uint16_t>(v / 4, u / 4);
      const bool hole = (u / 4) % 3 == 0 || stored == UINT16_MAX;
      ASSERT_FLOAT_EQ(image->depth.at<float>(v, u), hole ? 0.0F : 1e-3F * stored);
      // Readings of medium confidence are noisier than the others.
      ASSERT_EQ(image->noise_factor.at<float>(v, u), (u / 4) % 3 == 1 ? kMediumConfidenceNoise : 1);
    }
  }
}

TEST(StrayScanner, ConfidenceIsRegisteredWithTheDepthOfAStatedCamera) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  RgbdSensor sensor{
      .camera = {.width = 64, .height = 48, .fx = 45, .fy = 45, .cx = 31.5, .cy = 23.5},
      .depth_factor = 1000.0};
  // Each of its pixels covers four by four of colour.
  sensor.depth_camera = DepthCameraCalibration{
      .camera = {.width = 16, .height = 12, .fx = 11.25, .fy = 11.25, .cx = 7.5, .cy = 5.5}};
  const auto image = OpenDataset(folder.path(), sensor)->Load(2);
  ASSERT_TRUE(image);
  const auto is_full = [raw = RandomDepth({16, 12}, 3)](int u, int v) {
    return raw.at<std::uint16_t>(v, u) == UINT16_MAX;
  };
  ASSERT_EQ(image->noise_factor.size(), image->depth.size());
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const int confidence = (u / 4) % 3;
      ASSERT_EQ(image->depth.at<float>(v, u) == 0.0F, confidence == 0 || is_full(u / 4, v / 4))
          << u << " " << v;
      ASSERT_EQ(image->noise_factor.at<float>(v, u), confidence == 1 ? kMediumConfidenceNoise : 1)
          << u << " " << v;
    }
  }
}

TEST(StrayScanner, DepthOfHighConfidenceHasTheNoiseOfTheSensor) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  WriteImage(folder / "confidence/000000.png", cv::Mat(12, 16, CV_8UC1, cv::Scalar(2)));
  EXPECT_TRUE(StrayScannerDataset(folder.path()).Load(0)->noise_factor.empty());
}

TEST(StrayScanner, ScalesTheMatrixToTheSizeOfTheFrames) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {1280, 960});
  const StrayScannerDataset dataset(folder.path());
  ASSERT_NE(dataset.calibration(), nullptr);
  const RgbdSensor& sensor = dataset.calibration()->sensor;
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_EQ(sensor.camera.width, 640);
  EXPECT_EQ(sensor.camera.height, 480);
  EXPECT_DOUBLE_EQ(sensor.camera.fx, 450.0);
  EXPECT_DOUBLE_EQ(sensor.camera.cx, 962.5 / 3.0 - 0.5);
  EXPECT_DOUBLE_EQ(sensor.camera.cy, 722.5 / 3.0 - 0.5);
  const auto image = dataset.Load(0);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->bgr.size(), cv::Size(640, 480));
  EXPECT_EQ(image->depth.size(), cv::Size(640, 480));
}

TEST(StrayScanner, AMatrixWrittenForTheImagesIsTakenAsItIs) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  WriteText(folder / "camera_matrix.csv", "45 0 32\n0 45 24\n0 0 1\n");
  EXPECT_EQ(StrayScannerDataset(folder.path()).calibration()->sensor.camera.cx, 32.0);
}

TEST(StrayScanner, ReadsTheIntrinsicsOfEachFrame) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  std::string odometry =
      "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy\n"
      "1, 0, 0, 0, 0, 0, 0, 0, 1, 1300, 1300, 960, 720\n"
      "2, 1, 0, 0, 0, 0, 0, 0, 1, 1350, 1350, 960, 720\n"
      "3, 3, 0, 0, 0, 0, 0, 0, 1, 1400, 1400, 960, 720\n";
  WriteText(folder / "odometry.csv", odometry);
  const StrayScannerDataset dataset(folder.path());
  EXPECT_DOUBLE_EQ(dataset.calibration()->sensor.camera.fx, 1350.0 / 30.0);
  const auto same = dataset.Load(1), other = dataset.Load(2);
  ASSERT_TRUE(same && other);
  EXPECT_EQ(cv::norm(same->bgr, RandomColour({64, 48}, 1), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(other->bgr, RandomColour({64, 48}, 3), cv::NORM_INF), 0.0);
}

TEST(StrayScanner, ItsPosesAreTheReference) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  const StrayScannerDataset dataset(folder.path());
  ASSERT_NE(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.groundtruth()->size(), 4U);
  const StampedPose& pose = dataset.groundtruth()->at(3);
  EXPECT_EQ(pose.stamp, 101'500'000'000);
  EXPECT_EQ(pose.pose.p(), Eigen::Vector3d(3, 2, 3));
  EXPECT_NEAR(pose.pose.q().w(), 0.8, 1e-12);
}

TEST(StrayScanner, ItsImuIsReadWithTheSignAndTheAxesOfThePhone) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  const StrayScannerDataset dataset(folder.path());
  ASSERT_TRUE(dataset.imu_file());
  const ImuRecording imu = ReadImu(*dataset.imu_file(), {dataset.stamp(0), dataset.stamp(2)});
  ASSERT_EQ(imu.samples.size(), 2U);
  EXPECT_EQ(imu.samples[0].stamp, 100'250'000'000);
  EXPECT_EQ(imu.samples[0].gyroscope, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(imu.samples[0].accelerometer, Eigen::Vector3d(9.8, -0.5, -0.25));
  EXPECT_NE(imu.warning.find("reads gravity, as iOS has it"), std::string::npos) << imu.warning;
  ASSERT_TRUE(dataset.calibration()->imu);
  const Pose& T_BC = dataset.calibration()->imu->T_BC;
  EXPECT_TRUE((T_BC * Eigen::Vector3d(1, 2, 3)).isApprox(Eigen::Vector3d(-2, -1, -3), 1e-12));
}

TEST(StrayScanner, ReadsItsVideoInAnyOrder) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  const std::string video = (folder / "rgb.mp4").string();
  cv::VideoWriter writer(video, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 30.0, {64, 48});
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 4; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(60 * i, 40, 90)));
  writer.release();
  std::vector<cv::Mat> images;
  cv::VideoCapture reader(video);
  for (cv::Mat image; reader.read(image);) images.push_back(image.clone());
  ASSERT_EQ(images.size(), 4U);
  const StrayScannerDataset dataset(folder.path());
  const std::vector<std::size_t> numbers{0, 1, 3};
  for (const std::size_t frame : {2UL, 0UL, 0UL, 1UL}) {
    const auto image = dataset.Load(frame);
    ASSERT_TRUE(image);
    EXPECT_EQ(cv::norm(image->bgr, images[numbers[frame]], cv::NORM_INF), 0.0) << frame;
  }
}

TEST(StrayScanner, AVideoThatEndsTooEarlyIsAProblemOfItsFrames) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  const std::string video = (folder / "rgb.mp4").string();
  cv::VideoWriter writer(video, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 30.0, {64, 48});
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 2; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(60 * i, 40, 90)));
  writer.release();
  const StrayScannerDataset dataset(folder.path());
  EXPECT_TRUE(dataset.Load(1));
  EXPECT_FALSE(dataset.Load(2));
  ASSERT_EQ(dataset.problems().size(), 1U);
  EXPECT_NE(dataset.problems()[0].what.find("rgb.mp4: has no image 3: it ends after 2"),
            std::string::npos)
      << dataset.problems()[0].what;
}

TEST(StrayScanner, NamesWhatIsMissingOrMalformed) {
  const auto message = [](const char* file, const char* text) {
    const TemporaryDirectory folder(file);
    WriteStray(folder.path());
    WriteStrayImages(folder.path(), {64, 48});
    if (text == nullptr) {
      fs::remove_all(folder / file);
    } else {
      WriteText(folder / file, text);
    }
    const std::string what = MessageOf<IoError>([&] { StrayScannerDataset(folder.path()); });
    EXPECT_EQ(what.find('\n'), std::string::npos);
    return what.substr(std::min(what.size(), folder.path().string().size()));
  };
  const std::string heading = kStrayHeading;
  EXPECT_EQ(message("rgb", nullptr),
            "/rgb.mp4: is missing, and there is no folder rgb with images: copy one of them");
  EXPECT_NE(message("camera_matrix.csv", nullptr).find("camera_matrix.csv: "), std::string::npos);
  EXPECT_EQ(message("camera_matrix.csv", "1 0 2\n0 1\n"),
            "/camera_matrix.csv:2: has 2 of 3 lines of 3 numbers");
  EXPECT_EQ(message("camera_matrix.csv", "1 0 2\n0 1 2\n"),
            "/camera_matrix.csv: has 2 of 3 lines of 3 numbers");
  EXPECT_EQ(message("camera_matrix.csv", "1 0 2\n0 a 2\n0 0 1\n"),
            "/camera_matrix.csv:2: 'a' is not a number");
  EXPECT_EQ(message("camera_matrix.csv", "nan 0 2\n0 1 2\n0 0 1\n"),
            "/camera_matrix.csv: the camera matrix must be nine finite numbers");
  EXPECT_EQ(message("camera_matrix.csv", "1350 0 962\n3 1350 722\n0 0 1\n"),
            "/camera_matrix.csv: the camera matrix must be fx 0 cx, 0 fy cy, 0 0 1");
  EXPECT_NE(message("camera_matrix.csv", "1350 0 19620\n0 1350 722\n0 0 1\n")
                .find("camera_matrix.csv: PinholeCamera::cx"),
            std::string::npos);
  EXPECT_EQ(message("odometry.csv", heading.c_str()), "/odometry.csv: holds no pose");
  EXPECT_EQ(message("odometry.csv", (heading + "1, 0, 1, 2, 3, 0, 0, 0\n").c_str()),
            "/odometry.csv:2: has 8 of the 9 values timestamp, frame, x, y, z, qx, qy, qz, qw");
  EXPECT_EQ(message("odometry.csv", (heading + "1, 0, nan, 2, 3, 0, 0, 0, 1\n").c_str()),
            "/odometry.csv:2: 'nan' is not a finite number");
  EXPECT_EQ(message("odometry.csv", (heading + "1, 0, 1, 2, 3, 0, 0, 0, 0\n").c_str()),
            "/odometry.csv:2: its quaternion is zero or not finite");
  EXPECT_EQ(message("odometry.csv", "timestamp, x, y, z\n1, 1, 2, 3\n"),
            "/odometry.csv:1: names no column 'frame'");
}

TEST(StrayScanner, AFrameThatCannotBeReadIsAProblem) {
  const TemporaryDirectory folder;
  WriteStray(folder.path());
  WriteStrayImages(folder.path(), {64, 48});
  WriteImage(folder / "depth/000001.png", cv::Mat(12, 12, CV_16UC1, cv::Scalar(1000)));
  WriteImage(folder / "confidence/000003.png", cv::Mat(6, 8, CV_8UC1, cv::Scalar(2)));
  const StrayScannerDataset dataset(folder.path());
  EXPECT_TRUE(dataset.Load(0));
  EXPECT_FALSE(dataset.Load(1));
  EXPECT_FALSE(dataset.Load(2));
  const auto problems = dataset.problems();
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_NE(problems[0].what.find("confidence/000001.png: is 16 x 12, but its depth image is"),
            std::string::npos)
      << problems[0].what;
  EXPECT_NE(problems[1].what.find("000003.png: is 8 x 6, but its depth image is 16 x 12"),
            std::string::npos)
      << problems[1].what;
}

TEST(StrayScanner, ReadsARealExcerpt) {
  const fs::path excerpt = fs::path(testing::kSharedData) / "layouts/stray_scanner";
  if (!fs::exists(excerpt)) GTEST_SKIP() << excerpt << ": no shared/data here";
  // Its video is not there.
  EXPECT_NE(MessageOf<IoError>([&] { StrayScannerDataset{excerpt}; }).find("rgb.mp4: is missing"),
            std::string::npos);
  const TemporaryDirectory folder;
  fs::copy(excerpt, folder.path(), fs::copy_options::recursive);
  for (int i = 0; i < 20; ++i) {
    WriteImage(folder / ("rgb/" + SixDigits(i) + ".jpg"), RandomColour({192, 144}, i));
  }
  const StrayScannerDataset dataset(folder.path());
  ASSERT_EQ(dataset.size(), 20U);
  EXPECT_EQ(dataset.stamp(0), 258528'330'141'458);
  const cv::Mat raw = cv::imread((excerpt / "depth/000004.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat sure =
      cv::imread((excerpt / "confidence/000004.png").string(), cv::IMREAD_UNCHANGED);
  const auto image = dataset.Load(4);
  ASSERT_TRUE(image);
  for (int v = 0; v < 144; ++v) {
    for (int u = 0; u < 192; ++u) {
      const int row = (2 * v + 1) * 192 / 288, column = (2 * u + 1) * 256 / 384;
      const float z = 1e-3F * raw.at<std::uint16_t>(row, column);
      ASSERT_FLOAT_EQ(image->depth.at<float>(v, u),
                      sure.at<unsigned char>(row, column) == 0 ? 0.0F : z);
    }
  }
}

std::string FiveDigits(int number) {
  return SixDigits(number).substr(1);
}

// Row by row; the camera looks along -z of ARKit's frame.
std::string ScannerJson(int i, double focal) {
  return "{\n  \"frame_index\" : " + std::to_string(i) + ",\n  \"time\" : 50." + std::to_string(i) +
         ",\n  \"intrinsics\" : [" + std::to_string(focal) + ", 0, 31.5, 0, " +
         std::to_string(focal) + ", 23.5, 0, 0, 1],\n  \"cameraPoseARFrame\" : [0, -1, 0, " +
         std::to_string(i) + ", 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 0.9999999]\n}\n";
}

// Six depth images, of which each second has a colour image of 64 x 48.
void WriteScannerApp(const fs::path& folder) {
  const cv::Size size(16, 12);
  for (int i = 0; i < 6; ++i) {
    WriteText(folder / ("frame_" + FiveDigits(i) + ".json"), ScannerJson(i, i == 4 ? 60.0 : 50.0));
    WriteImage(folder / ("depth_" + FiveDigits(i) + ".png"), RandomDepth(size, i));
    WriteImage(folder / ("conf_" + FiveDigits(i) + ".png"), Confidence(size));
    if (i % 2 == 0) {
      WriteImage(folder / ("frame_" + FiveDigits(i) + ".png"), RandomColour({64, 48}, i));
    }
  }
  WriteImage(folder / "thumb_00000.jpg", RandomColour({8, 6}, 0));
}

TEST(ScannerApp, FramesAreTheColourImagesWithTheirDepth) {
  const TemporaryDirectory folder;
  WriteScannerApp(folder.path());
  const auto dataset = OpenDataset(folder.path());
  ASSERT_NE(dynamic_cast<const ScannerAppDataset*>(dataset.get()), nullptr);
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->stamp(1), 50'200'000'000);
  EXPECT_TRUE(dataset->warnings().empty());
  const auto image = dataset->Load(1);
  ASSERT_TRUE(image);
  EXPECT_EQ(cv::norm(image->bgr, RandomColour({64, 48}, 2), cv::NORM_INF), 0.0);
  const cv::Mat raw = RandomDepth({16, 12}, 2);
  EXPECT_FLOAT_EQ(image->depth.at<float>(9, 21), 1e-3F * raw.at<std::uint16_t>(2, 5));
  EXPECT_EQ(image->depth.at<float>(9, 25), 0.0F);  // confidence 0
}

TEST(ScannerApp, AMovedFocusIsUndone) {
  const TemporaryDirectory folder;
  WriteScannerApp(folder.path());
  const ScannerAppDataset dataset(folder.path());
  EXPECT_DOUBLE_EQ(dataset.calibration()->sensor.camera.fx, 50.0);
  const auto image = dataset.Load(2);
  ASSERT_TRUE(image);
  // The pixel 21.5 px right of the centre is 25.8 px from it in the image, at 57.3.
  const cv::Mat raw = RandomDepth({16, 12}, 4);
  EXPECT_FLOAT_EQ(image->depth.at<float>(24, 53), 1e-3F * raw.at<std::uint16_t>(6, 14));
}

TEST(ScannerApp, TurnsThePosesOfArkitForward) {
  const TemporaryDirectory folder;
  WriteScannerApp(folder.path());
  const ScannerAppDataset dataset(folder.path());
  ASSERT_NE(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.groundtruth()->size(), 3U);
  const Pose& T_WC = dataset.groundtruth()->at(1).pose;
  EXPECT_TRUE(T_WC.p().isApprox(Eigen::Vector3d(2, 2, 3)));
  Eigen::Matrix3d forward;
  forward << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  EXPECT_TRUE(T_WC.R().isApprox(forward, 1e-9)) << T_WC.R();
}

TEST(ScannerApp, AnImageWithABrokenJsonIsLeftOutWithOneWarning) {
  const TemporaryDirectory folder;
  WriteScannerApp(folder.path());
  WriteText(folder / "frame_00002.json", ScannerJson(2, 50.0).substr(0, 60));
  fs::remove(folder / "frame_00004.json");
  const ScannerAppDataset dataset(folder.path());
  EXPECT_EQ(dataset.size(), 1U);
  ASSERT_EQ(dataset.warnings().size(), 1U);
  EXPECT_NE(dataset.warnings()[0].find("frame_00002.json:"), std::string::npos);
  EXPECT_NE(dataset.warnings()[0].find("; 2 images are not used"), std::string::npos);
}

TEST(ScannerApp, NamesTheMemberThatIsMissingOrMalformed) {
  const auto message = [](const std::string& json) {
    const TemporaryDirectory folder;
    WriteScannerApp(folder.path());
    for (int i = 0; i < 6; i += 2) WriteText(folder / ("frame_" + FiveDigits(i) + ".json"), json);
    return MessageOf<IoError>([&] { ScannerAppDataset(folder.path()); });
  };
  const auto expect = [&](const std::string& json, const std::string& part) {
    const std::string what = message(json);
    EXPECT_NE(what.find("frame_00000.json" + part), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  };
  expect("[1, 2]", ": is not a JSON object");
  expect("{}", ": has no 'time'");
  expect("{\n\"time\": \"late\"}", ":2: 'time' must be a time in seconds");
  expect("{\"time\": 1,\n\"intrinsics\": [1, 2]}", ":2: 'intrinsics' must be a list of 9 finite");
  expect("{\"time\": 1, \"intrinsics\": [50,0,31,0,50,23,0,0,1]}", ": has no 'cameraPoseARFrame'");
  expect(
      "{\"time\": 1, \"intrinsics\": [50,0,31,0,50,23,0,0,1], "
      "\"cameraPoseARFrame\": [1,0,0,0,0,1,0,0,0,0,2,0,0,0,0,1]}",
      ": 'cameraPoseARFrame' is no rotation and translation, row by row");
}

TEST(ScannerApp, ReadsARealExcerpt) {
  const fs::path folder = fs::path(testing::kSharedData) / "layouts/3d_scanner_app";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << ": no shared/data here";
  const ScannerAppDataset dataset(folder);
  ASSERT_EQ(dataset.size(), 5U);
  EXPECT_EQ(dataset.stamp(0), 104137'339'887'875);
  EXPECT_EQ(dataset.calibration()->sensor.camera.width, 640);
  EXPECT_NEAR(dataset.calibration()->sensor.camera.fx, 1590.2056884765625 / 3.0, 1e-9);
  const auto image = dataset.Load(0);  // its focal length is the median
  ASSERT_TRUE(image);
  const cv::Mat colour = cv::imread((folder / "frame_00000.jpg").string());
  const cv::Mat raw = cv::imread((folder / "depth_00000.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat sure = cv::imread((folder / "conf_00000.png").string(), cv::IMREAD_UNCHANGED);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const cv::Scalar mean = cv::mean(colour(cv::Rect(3 * u, 3 * v, 3, 3)));
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(image->bgr.at<cv::Vec3b>(v, u)[c], mean[c], 0.51);
      const int row = (2 * v + 1) * 192 / 960, column = (2 * u + 1) * 256 / 1280;
      const float z = 1e-3F * raw.at<std::uint16_t>(row, column);
      ASSERT_FLOAT_EQ(image->depth.at<float>(v, u),
                      sure.at<unsigned char>(row, column) == 0 ? 0.0F : z);
    }
  }
}

}  // namespace
}  // namespace highwall::phone_datasets_test
