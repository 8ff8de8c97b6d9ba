// Provokes every message that docs/troubleshooting.md quotes, and those of
// self_explanatory_messages.txt, which state their remedy themselves or need none, and checks
// Highwall's output for it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>
#include <highwall/core/factor_graph.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/pose/pose_report.h>
#include <highwall/frontend/system/slam_system.h>

#include "quoted_messages.h"
#include "run/loss_advice.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/generated_tum.h"
#include "support/message_of.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::apps::troubleshooting_test {
namespace {

namespace fs = std::filesystem;
using testing::GeneratedTum;
using testing::WriteText;

constexpr const char* kCalibration =
    "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 32, cy: 24}\n";

// Collects the lines that all the cases print.
class Troubleshooting : public ::testing::Test {
 protected:
  void Highwall(const std::string& arguments) {
    const testing::Outcome outcome =
        testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
    for (const std::string& line : Lines(outcome.err + outcome.out)) said_.push_back(line);
  }
  // Writes blank frames with a calibration.
  fs::path Dataset(const std::string& name, const GeneratedTum& tum = {},
                   const std::string& calibration = "depth_factor: 5000\n") {
    const fs::path dataset = folder_.path() / name;
    testing::WriteTum(dataset, tum);
    WriteText(dataset / "calibration.yaml", kCalibration + calibration);
    return dataset;
  }
  void Slam(const std::string& dataset, const std::string& switches = "") {
    Highwall("slam --dataset " + dataset + " --out run " + switches);
  }

  void Calls();
  void Recordings();
  void OtherFormats();
  void Frames();
  void Calibrations();
  void Stereo();
  void Imus();
  void Fixes();
  void Sensors();
  void Runs();
  void PoseGraphs();
  void Losses();
  void Graphs();
  void Extractors();

  testing::TemporaryDirectory folder_{"troubleshooting"};
  std::vector<std::string> said_;
};

void Troubleshooting::Calls() {
  Highwall("slm");
  Highwall("slam --datset x --out y");
  Highwall("slam --out y");
  for (const char* switches :
       {"--features pionts", "--resolution 99", "--set tracker.min_suport=30",
        "--set tracker.min_support=3.5", "--set tracker.min_support=3", "--set localize_only=true",
        "--localize --load-map m --imu paper"}) {
    Slam("x", switches);
  }
}

void Troubleshooting::Recordings() {
  Slam("nowhere");
  fs::remove(Dataset("no_list") / "rgb.txt");
  Slam("no_list");
  fs::remove(Dataset("no_lists") / "rgb.txt");
  fs::remove(folder_.path() / "no_lists" / "depth.txt");
  fs::remove_all(folder_.path() / "no_lists" / "depth");
  Slam("no_lists");
  WriteText(Dataset("empty_list") / "rgb.txt", "# nothing\n");
  Slam("empty_list");
  WriteText(Dataset("no_stamp") / "rgb.txt", "soon rgb/100.png\n");
  Slam("no_stamp");
  WriteText(Dataset("other_clock") / "depth.txt", "7.5 depth/100.png\n");
  Slam("other_clock");
  fs::remove_all(Dataset("no_images") / "rgb");
  Slam("no_images");
  const fs::path gap = Dataset("gap");
  cv::Mat pattern(48, 64, CV_8UC3);
  cv::RNG(1).fill(pattern, cv::RNG::UNIFORM, 0, 255);
  cv::imwrite((gap / "rgb" / "100.png").string(), pattern);
  WriteText(gap / "rgb.txt",
            "1.0 rgb/100.png\n1.1 rgb/100.png\n1.2 rgb/102.png\n9.3 rgb/103.png\n");
  WriteText(gap / "depth.txt",
            "1.0 depth/100.png\n1.1 depth/101.png\n1.2 depth/102.png\n9.3 depth/103.png\n");
  Highwall("info gap");
  const fs::path wall = Dataset("wall");
  for (int i = 0; i < 6; ++i) {
    cv::imwrite((wall / "rgb" / (testing::FrameName(i) + ".png")).string(),
                cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90 + i)));
  }
  Highwall("info wall");
  const auto list = [&](const std::string& name, const std::string& text) {
    WriteText(Dataset(name) / "rgb.txt", text);
    Slam(name);
  };
  list("late_depth", "99.97 rgb/100.png\n100.07 rgb/101.png\n");
  list("some_late", "99.97 rgb/100.png\n100.07 rgb/101.png\n100.2 rgb/102.png\n");
  list("milliseconds", "100000 rgb/100.png\n100100 rgb/101.png\n");
  list("exchanged", "100.1 rgb/101.png\n100.0 rgb/100.png\n");
  list("doubled", "100.1 rgb/101.png\n100.1 rgb/100.png\n");
  list("whole_seconds", "100 rgb/100.png\n100 rgb/101.png\n100 rgb/102.png\n");
  WriteText(Dataset("bad_truth") / "groundtruth.txt", "100.0 nan 0 0 0 0 0 1\n");
  Slam("bad_truth");
}

// Recordings of other programs than the TUM benchmark's.
void Troubleshooting::OtherFormats() {
  constexpr const char* kIntrinsic =
      R"({"width": 64, "height": 48, "intrinsic_matrix": [50,0,0,0,50,0,31,23,1]})";
  const auto images = [&](const std::string& name) {
    const fs::path folder = Dataset(name);
    for (const char* const file : {"rgb.txt", "depth.txt", "calibration.yaml"}) {
      fs::remove(folder / file);
    }
    return folder;
  };
  const auto info = [&](const std::string& name, const std::string& file, const std::string& text) {
    WriteText(folder_.path() / name / file, text);
    Highwall("info " + name);
  };
  const fs::path pairs = images("pairs");
  Highwall("info pairs");
  for (int i = 0; i < 6; ++i) {
    const std::string name = testing::FrameName(i) + ".png";
    fs::rename(pairs / "depth" / name, pairs / "depth" / ("9" + name));
  }
  Highwall("info pairs");
  fs::rename(images("open3d") / "rgb", folder_.path() / "open3d" / "color");
  info("open3d", "camera_intrinsic.json", "{}");
  info("open3d", "camera_intrinsic.json",
       R"({"width": 64, "height": 64, "intrinsic_matrix": [50,0,0,0,50,0,31,23,1]})");
  WriteText(folder_.path() / "open3d" / "camera_intrinsic.json", kIntrinsic);
  info("open3d", "trajectory.log", "0 0 1\n1 0 0\n");
  for (int i = 0; i < 6; ++i) {
    cv::imwrite((folder_.path() / "open3d/depth" / (testing::FrameName(i) + ".png")).string(),
                cv::Mat(24, 32, CV_16UC1, cv::Scalar(1000)));
  }
  Highwall("info open3d");
  images("stray");
  info("stray", "odometry.csv", "100, 100, 0, 0, 0, 0, 0, 0, 1\n101, 101, 0, 0, 0, 0, 0, 0, 1\n");
  info("stray", "camera_matrix.csv", "1350 0 960\n0 1350 720\n");
  info("stray", "camera_matrix.csv", "1350 1 960\n0 1350 720\n0 0 1\n");
  WriteText(folder_.path() / "stray/camera_matrix.csv", "1350 0 960\n0 1350 720\n0 0 1\n");
  info("stray", "imu.csv",
       "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n100.5,-9.8,0,0,0,0,0\n");
  fs::remove_all(folder_.path() / "stray" / "rgb");
  Highwall("info stray");
}

void Troubleshooting::Frames() {
  const fs::path depth = Dataset("bad_frames") / "depth";
  testing::Truncate(depth / "101.png");
  cv::imwrite((depth / "102.png").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
  cv::imwrite((depth / "103.png").string(), cv::Mat(24, 32, CV_16UC1, cv::Scalar(5000)));
  Slam("bad_frames");
}

void Troubleshooting::Calibrations() {
  Dataset("other_size", {.width = 32, .height = 24});
  Slam("other_size");
  Dataset("other_unit", {}, "depth_factor: 1\n");
  Slam("other_unit");
  fs::remove(Dataset("no_calibration") / "calibration.yaml");
  Slam("no_calibration");
  Slam("no_calibration", "--config tum4");
  Dataset("misspelt", {}, "depth_facter: 5000\n");
  Slam("misspelt");
  const std::string camera = "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 32, cy: 24, ";
  WriteText(Dataset("prism") / "calibration.yaml", camera + "s1: 1}\n");
  Slam("prism");
  WriteText(Dataset("fisheye") / "calibration.yaml", camera + "lens: fisheye}\n");
  Slam("fisheye");
  WriteText(Dataset("librealsense") / "calibration.yaml", "ppx: 32\nppy: 24\n");
  Slam("librealsense");
  const std::string ros =
      "image_width: 64\nimage_height: 48\ncamera_matrix: {data: [50, 0, 32, 0, 50, 24, 0, 0, 1]}\n";
  WriteText(Dataset("ros") / "calibration.yaml", ros + "distortion_model: plumb_bob\n");
  Slam("ros");
  WriteText(folder_ / "orb.yaml", "%YAML:1.0\nCamera.fx: 50\n");
  Highwall("convert orb.yaml out.yaml");
  WriteText(Dataset("fov") / "calibration.yaml", ros + "distortion_model: fov\nD: [0.9]\n");
  Slam("fov");
  Dataset("missing", {}, "");
  Slam("missing");
  Dataset("no_sensor", {}, "sensor: kinectt1\n");
  Slam("no_sensor");
}

// A stereo pair, with faults in the calibration of one camera and in its list.
void Troubleshooting::Stereo() {
  const auto yaml = [&](const std::string& x, const std::string& model = "pinhole",
                        const std::string& size = "64, 48",
                        const std::string& second_row = "0, 1, 0, 0",
                        const std::string& lens = "radial-tangential") {
    return "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + x + ", " + second_row +
           ", 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [" + size + "]\ncamera_model: " + model +
           "\nintrinsics: [50, 50, 32, 24]\ndistortion_model: " + lens +
           "\ndistortion_coefficients: [0, 0, 0, 0]\n";
  };
  const std::string all = "1000,1000.png\n2000,2000.png\n3000,3000.png\n";
  const auto slam = [&](const std::string& name, const std::string& right,
                        const std::string& list) {
    for (const char* camera : {"cam0", "cam1"}) {
      const fs::path place = folder_.path() / name / "mav0" / camera;
      fs::create_directories(place / "data");
      for (const char* image : {"1000.png", "2000.png", "3000.png"}) {
        cv::imwrite((place / "data" / image).string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
      }
      const bool left = std::string(camera) == "cam0";
      WriteText(place / "data.csv", left ? all : list);
      WriteText(place / "sensor.yaml", left ? yaml("0.0") : right);
    }
    Slam(name);
  };
  slam("stereo_clock", yaml("0.1"), "7,7.png\n");
  slam("stereo_some", yaml("0.1"), "1000,1000.png\n2000,2000.png\n");
  slam("stereo_list", yaml("0.1"), "1000\n");
  slam("stereo_omni", yaml("0.1", "omni"), all);
  slam("stereo_fisheye", yaml("0.1", "pinhole", "64, 48", "0, 1, 0, 0", "equidistant"), all);
  slam("stereo_skewed", yaml("0.1", "pinhole", "64, 48", "0, 7, 0, 0"), all);
  slam("stereo_size", yaml("0.1", "pinhole", "32, 24"), all);
  slam("stereo_left", yaml("-0.1"), all);
  Highwall("info stereo_some");
}

// Readings at 200 Hz that overlap the video in time.
struct Reading {
  std::int64_t stamp;            // [ns]
  std::array<double, 6> values;  // [rad/s], [m/s^2]
};
using Readings = std::vector<Reading>;

Readings GoodReadings() {
  Readings readings;
  for (int i = 0; i <= 120; ++i) {
    readings.push_back({99'950'000'000 + i * 5'000'000LL, {0.1, 1e-4 * i, 0, 0, 1e-3 * i, 9.81}});
  }
  return readings;
}

std::string ToText(const Readings& readings) {
  std::ostringstream text;
  for (const Reading& reading : readings) {
    text << reading.stamp;
    for (const double value : reading.values) text << ',' << value;
    text << '\n';
  }
  return text.str();
}

void Troubleshooting::Imus() {
  const auto inspect = [this](const std::string& name, const auto& spoil) {
    Readings readings = GoodReadings();
    spoil(readings);
    WriteText(Dataset(name) / "imu.csv", ToText(readings));
    Highwall("info " + name);
  };
  const auto scale = [](int first, double factor) {
    return [=](Readings& readings) {
      for (Reading& reading : readings) {
        for (int i = first; i < first + 3; ++i)
          reading.values[static_cast<std::size_t>(i)] *= factor;
      }
    };
  };
  const auto freeze = [](int first) {
    return [=](Readings& readings) {
      for (Reading& reading : readings) {
        std::copy_n(readings.front().values.begin() + first, 3, reading.values.begin() + first);
      }
    };
  };
  inspect("imu_g", scale(3, 1.0 / 9.80665));
  inspect("imu_unit", scale(3, 1.0 / 8.0));
  inspect("imu_no_unit", scale(3, 0.3));
  inspect("imu_degrees", scale(0, 300.0));
  inspect("imu_exchanged", [](Readings& readings) {
    for (Reading& r : readings) {
      std::swap_ranges(r.values.begin(), r.values.begin() + 3, r.values.begin() + 3);
    }
  });
  inspect("imu_gravity", [](Readings& readings) {
    for (Reading& r : readings) r.values[5] -= 9.81;
  });
  inspect("imu_gyroscope", freeze(0));
  inspect("imu_accelerometer", freeze(3));
  for (const std::string range :
       {"accelerometer_range: 4", "gyroscope_range: 500", "accelerometer_range: 9.81"}) {
    const std::string name = "imu_range_" + range.substr(0, 1) + range.substr(range.size() - 1);
    const fs::path calibration = Dataset(name) / "calibration.yaml";
    WriteText(calibration,
              testing::ReadText(calibration) +
                  "imu:\n  T_BC: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n  " + range +
                  "\n");
    Readings strong = GoodReadings();
    for (Reading& reading : strong) reading.values[3] += 11.0;
    WriteText(calibration.parent_path() / "imu.csv", ToText(strong));
    Highwall("info " + name);
  }
  inspect("imu_nan", [](Readings& r) { r[5].values[0] = std::nan(""); });
  inspect("imu_impossible", [](Readings& r) { r[5].values[0] = 5e3; });
  inspect("imu_order", [](Readings& r) { std::swap(r[5], r[6]); });
  inspect("imu_twice", [](Readings& r) { r[5].stamp = r[6].stamp; });
  inspect("imu_late", [](Readings& r) { r.erase(r.begin(), r.begin() + 40); });
  inspect("imu_early", [](Readings& r) { r.resize(60); });
  inspect("imu_gap", [](Readings& r) { r.erase(r.begin() + 40, r.begin() + 70); });
  inspect("imu_micro", [](Readings& r) {
    for (Reading& reading : r) reading.stamp /= 1000;
  });
  WriteText(Dataset("imu_columns") / "imu.csv", "99900000000,0,0,0,0,0\n");
  Slam("imu_columns");
  WriteText(Dataset("imu_many_columns") / "imu.csv", "99900000000,0,0,0,0,0,0,0,0,0\n");
  Slam("imu_many_columns");
  Readings readings = GoodReadings();
  for (Reading& reading : readings) reading.stamp -= 90'000'000'000;
  WriteText(Dataset("imu_clock") / "imu.csv", ToText(readings));
  Slam("imu_clock");
  Dataset("no_imu");
  Slam("no_imu", "--imu paper");
}

void Troubleshooting::Fixes() {
  for (const char* text :
       {"100.1,1,2\n", "1305031102175304123,1,2,3\n", "100.1,1,2,three\n", "100.1,1,2,3,0,1,1\n",
        "100.1,1,2,1e12\n", "# stamp lat lon alt\n100.1,455000,11,520\n", "100.1,nan,nan,nan\n"}) {
    WriteText(Dataset("fixes") / "gps.csv", text);
    Slam("fixes");
  }
}

// A walk through a room, for messages that only a run with poses can give.
void Troubleshooting::Sensors() {
  simulate::SimulationOptions options;
  options.camera = simulate::Scaled(options.camera, 0.5);
  const auto write = [&](const std::string& name, double seconds) {
    options.fps = 12.0;
    options.duration = seconds;
    options.sensor.noise_ratio = options.imu.noise_ratio = 1.0;  // as in the system's noise model
    simulate::WriteTum(simulate::SimulateRoom(options), folder_.path() / name);
  };
  const auto edit = [&](const fs::path& file, const std::regex& what, const std::string& by) {
    const fs::path path = folder_.path() / file;
    WriteText(path, std::regex_replace(testing::ReadText(path), what, by));
  };
  write("long_depth", 20.0);
  const std::regex factor("depth_factor: [0-9.]+");
  edit("long_depth/calibration.yaml", factor, "depth_factor: 4630");  // of 5000
  Slam("long_depth", "--no-map --deterministic");
  // Gravity points upwards, and no GPS fix matches a frame.
  write("unused", 2.0);
  edit("unused/imu.csv", std::regex("-?([0-9.e-]+)\n"), "-$1\n");
  WriteText(folder_.path() / "unused" / "gps.csv", "0.1,1,2,3\n0.2,1,2,4\n");
  Slam("unused", "--no-map");
  Map blank;
  blank.AddKeyFrame({.features = std::make_shared<FrameFeatures>()}, Pose());
  for (const PinholeCamera& camera : {PinholeCamera(), options.camera}) {
    SaveMap(folder_.path() / "elsewhere.hwmap", camera, blank);
    Slam("unused", "--imu off --no-map --localize --load-map elsewhere.hwmap");
  }
}

void Troubleshooting::PoseGraphs() {
  const auto solve = [&](const std::string& text, const std::string& switches = "") {
    WriteText(folder_.path() / "graph.g2o", text);
    Highwall("posegraph graph.g2o solved.g2o " + switches);
  };
  const auto edge = [](int i, int j, double x) {
    return "EDGE_SE2 " + std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(x) +
           " 0 0 100 0 0 100 0 100\n";
  };
  const auto vertex = [](int i) {
    return "VERTEX_SE2 " + std::to_string(i) + " " + std::to_string(i) + " 0 0\n";
  };
  solve(vertex(0) + vertex(1));
  solve(edge(0, 1, 1), "--init given");
  std::string chain;
  for (int i = 0; i < 12; ++i) chain += vertex(i);
  for (int i = 0; i + 1 < 12; ++i) chain += edge(i, i + 1, 1);
  for (int i = 0; i + 3 < 12; ++i) chain += edge(i, i + 3, 3);
  solve(chain + edge(0, 9, -20) + vertex(20) + vertex(21) + edge(20, 21, 1), "--robust gnc");
}

void Troubleshooting::Runs() {
  const fs::path plain = Dataset("plain", {.raw_depth = 20000});
  Slam("plain");
  Slam("plain", "--resolution 0.001");
  std::string poses;
  for (int i = 0; i < 6; ++i) poses += "100." + std::to_string(i) + " 0 0 0 0 0 0 1\n";
  WriteText(plain / "groundtruth.txt", poses);
  Highwall("map plain --resolution 0.001 --memory-limit 1 --out map");
  WriteText(folder_.path() / "notes.txt", "no map\n");
  Slam("plain", "--load-map notes.txt");
  const fs::path map = folder_.path() / "half.hwmap";
  SaveMap(map, PinholeCamera(), Map());
  testing::Truncate(map, 0.9);
  Slam("plain", "--load-map half.hwmap");
  Map sift;
  sift.SetFeatureType({.name = "sift"});
  SaveMap(folder_.path() / "sift.hwmap", PinholeCamera(), sift);
  Slam("plain", "--load-map sift.hwmap");
  Map coarse;
  coarse.SetFeatureType({.pyramid = {.levels = 4}});
  SaveMap(folder_.path() / "coarse.hwmap", PinholeCamera(), coarse);
  Slam("plain", "--load-map coarse.hwmap");
  Slam("plain", "--load-map plain");
  Highwall("slam --dataset plain --out notes.txt");
  Highwall("slam --dataset plain --out plain");
  Highwall("merge plain gap --out both");
  Highwall("merge plain plain --out both");
  WriteText(folder_.path() / "later.txt", "900.0 0 0 0 0 0 0 1\n");
  Highwall("eval ape plain/groundtruth.txt later.txt");
  Highwall("eval ape plain/groundtruth.txt nowhere.txt");
  WriteText(folder_.path() / "empty.g2o", "");
  Highwall("posegraph empty.g2o solved.g2o");
}

// The tests of the tracker and of SlamSystem check that each reason is detected in images.
void Troubleshooting::Losses() {
  for (const LossReason reason :
       {LossReason::kDark, LossReason::kBlurred, LossReason::kPlain, LossReason::kNoDepth,
        LossReason::kTooFast, LossReason::kContradictory, LossReason::kAllMoving,
        LossReason::kUnknownPlace, LossReason::kRepeatedImage, LossReason::kDeadReckoning}) {
    said_.push_back(LossAdvice({{ToString(reason), 1}}, 1));
  }
  said_.push_back(LossAdvice({{"dropped", 1}}, 1));
}

// A cost J x with these values of the residual and the Jacobian.
template <int kSize>
class Bad final : public ceres::SizedCostFunction<1, kSize> {
 public:
  Bad(double residual, double jacobian) : residual_(residual), jacobian_(jacobian) {}
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    residuals[0] = residual_;
    if (jacobians && jacobians[0]) std::fill_n(jacobians[0], kSize, jacobian_);
    return true;
  }

 private:
  double residual_, jacobian_;
};

void Troubleshooting::Graphs() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto solve = [&](double residual, double jacobian) {
    FactorGraph graph;
    graph.AddFactor(std::make_unique<Bad<1>>(residual, jacobian), graph.AddVariable(1.0));
    said_.push_back(graph.Solve().message);
  };
  solve(kNan, 1.0);
  solve(1.0, kNan);
  solve(1e160, 1.0);
  FactorGraph singular;
  const auto pair = singular.AddVariable(Eigen::Vector2d(1.0, 1.0));
  singular.AddFactor(std::make_unique<Bad<2>>(1.0, 1.0), pair);
  said_.push_back(singular.Undetermined());
  FactorGraph alone;
  alone.AddVariable(1.0);
  said_.push_back(alone.Undetermined());
  FactorGraph landmarks;
  const auto a = landmarks.AddLandmark(1.0), b = landmarks.AddLandmark(2.0);
  class Both final : public ceres::SizedCostFunction<1, 1, 1> {
    bool Evaluate(double const* const*, double*, double**) const override { return false; }
  };
  landmarks.AddFactor(std::make_unique<Both>(), a, b);
  said_.push_back(landmarks.Solve().message);
  said_.push_back(
      testing::MessageOf<InvalidArgument>([] { OrbExtractorOptions{.features = 0}.Validate(); }));
}

void Troubleshooting::Extractors() {
  class Outside final : public PointExtractor {
   public:
    const FeatureType& kind() const override { return kind_; }
    ExtractedPoints Extract(const cv::Mat& gray) override {
      return {{{static_cast<float>(gray.cols), 10.0F, 1.0F}}, cv::Mat::zeros(1, 32, CV_8U)};
    }

   private:
    FeatureType kind_{.name = "outside"};
  };
  const RgbdSensor sensor;
  const cv::Size size(sensor.camera.width, sensor.camera.height);
  const RgbdImage image{0, cv::Mat(size, CV_8UC3, cv::Scalar::all(90)),
                        cv::Mat(size, CV_32FC1, cv::Scalar(2.0))};
  SlamSystem slam(sensor, {}, {.points = std::make_shared<Outside>()});
  said_.push_back(testing::MessageOf<InvalidArgument>([&] { slam.Track(image); }));
  Map sift;
  sift.AddKeyFrame({.features = std::make_shared<const FrameFeatures>()}, Pose());
  sift.SetFeatureType({.name = "sift"});
  said_.push_back(testing::MessageOf<InvalidArgument>(
      [&] { SlamSystem(sensor, {}, {.map = std::move(sift)}); }));
}

TEST_F(Troubleshooting, EveryMessageOfThePageIsSaidAndNoneSpeaksOfTheCode) {
  Calls();
  Recordings();
  OtherFormats();
  Frames();
  Calibrations();
  Stereo();
  Imus();
  Fixes();
  Sensors();
  Runs();
  PoseGraphs();
  Losses();
  Graphs();
  Extractors();
  std::vector<std::string> messages = QuotedMessages();
  EXPECT_GT(messages.size(), 60u);
  for (std::string& message :
       Lines(testing::ReadText(std::string(testing::kSourceFolder) +
                               "/tests/expected/self_explanatory_messages.txt"))) {
    EXPECT_EQ(std::ranges::count(messages, message), 0) << message << " is on the page as well";
    messages.push_back(std::move(message));
  }
  for (const std::string& message : messages) {
    EXPECT_TRUE(std::ranges::any_of(said_, [&](const std::string& line) {
      return Says(line, message);
    })) << message;
  }
  for (const std::string& line : said_) {
    for (const char* code : {".cc:", ".h:", "ENUM", " >= 0)", "&&", "FAILED", "glog", "ceres"}) {
      EXPECT_FALSE(testing::Contains(line, code)) << line;
    }
  }
  if (HasFailure()) {
    for (const std::string& line : said_) std::cout << line << '\n';
  }
}

TEST(TroubleshootingPage, SaysMatchesVariableParts) {
  EXPECT_TRUE(Says("a b c", "a … c"));
  EXPECT_TRUE(Says("before a b", "a b"));
  EXPECT_FALSE(Says("c b a", "a … c"));
  EXPECT_FALSE(Says("a b", "b…b"));
}

}  // namespace
}  // namespace highwall::apps::troubleshooting_test
