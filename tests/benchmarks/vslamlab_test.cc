// Runs benchmarks/vslamlab/run_highwall as VSLAM-LAB does, on a sequence in its layout.
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::vslamlab_test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class VslamLab : public ::testing::Test {
 protected:
  void SetUp() override {
    simulate::SimulationOptions options;
    options.camera = simulate::Scaled(options.camera, 0.25);
    options.fps = 10.0;
    options.duration = 1.0;
    simulate::WriteTum(simulate::SimulateRoom(options), folder_ / "room");
    fs::rename(folder_ / "room/rgb", folder_ / "room/rgb_0");
    fs::rename(folder_ / "room/depth", folder_ / "room/depth_0");
    fs::rename(folder_ / "room/imu.csv", folder_ / "room/imu_0.csv");
    WriteText(folder_ / "room/rgb.csv", Images());
    WriteText(folder_ / "room/calibration.yaml",
              "%YAML 1.2\n---\ncameras:\n  - {cam_name: rgb_0, cam_type: rgb+depth, cam_model: "
              "pinhole,\n     focal_length: [131.25, 131.25], principal_point: [79.5, 59.5],\n"
              "     image_dimension: [160, 120], depth_factor: 5000.0}\n"
              "imus:\n  - {imu_name: imu_0, sigma_g_c: 2.44e-4, sigma_a_c: 1.47e-3,\n"
              "     sigma_gw_c: 2e-5, sigma_aw_c: 1e-3, fps: 200.0}\n");
    fs::create_directories(folder_ / "exp");
  }
  // Returns the list of images of the layout, from that of TUM RGB-D.
  std::string Images() const {
    std::istringstream list(ReadText(folder_ / "room/rgb.txt"));
    std::string lines = "ts_rgb_0 (ns),path_rgb_0,ts_depth_0 (ns),path_depth_0\n";
    for (std::string stamp, file; list >> stamp;) {
      std::getline(list, file);
      if (stamp.starts_with("#")) continue;
      const std::string name = file.substr(file.rfind('/') + 1);
      std::string nanoseconds = stamp;
      nanoseconds.erase(nanoseconds.find('.'), 1);
      nanoseconds.append(9 - (stamp.size() - stamp.find('.') - 1), '0');
      lines += nanoseconds + ",rgb_0/" + name + "," + nanoseconds + ",depth_0/" + name + "\n";
    }
    return lines;
  }
  Outcome Run(const std::string& options) const {
    return testing::RunProgram(
        std::string(testing::kSourceFolder) + "/benchmarks/vslamlab/run_highwall",
        "--highwall " + std::string(testing::kHighwallProgram) +
            " --sequence_path room --calibration_yaml room/calibration.yaml --rgb_csv room/rgb.csv"
            " --exp_folder exp --settings_yaml none.yaml --switches=--deterministic " +
            options,
        folder_.path());
  }

  testing::TemporaryDirectory folder_{"vslamlab"};
};

TEST_F(VslamLab, ASequenceGivesATrajectoryInItsFormat) {
  for (const std::string mode : {"rgbd", "rgbd-vi"}) {
    const Outcome outcome = Run("--mode " + mode + " --exp_it 3");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string trajectory = ReadText(folder_ / "exp/00003_KeyFrameTrajectory.csv");
    EXPECT_TRUE(trajectory.starts_with("ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw")) << trajectory;
    EXPECT_EQ(std::count(trajectory.begin(), trajectory.end(), '\n'), 11) << trajectory;
    EXPECT_TRUE(Contains(trajectory, "\n1500000000,")) << trajectory;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "exp"), {}), 1) << "nothing else stays";
}

TEST_F(VslamLab, NamesWhatASequenceLacks) {
  WriteText(folder_ / "room/calibration.yaml",
            "cameras: [{cam_name: rgb_0, focal_length: [1, 1], principal_point: [1, 1]}]\n");
  const Outcome outcome = Run("--mode rgbd --exp_it 0");
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_TRUE(Contains(outcome.err, "no depth_factor")) << outcome.err;
}

}  // namespace
}  // namespace highwall::vslamlab_test
