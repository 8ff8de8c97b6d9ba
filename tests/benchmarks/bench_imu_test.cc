// Runs highwall_bench_imu in the same way as a user: on generated motions, and on real ones where
// they are available.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/so3.h>

#include "support/imu_scene.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::bench_imu_test {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::filesystem::path& folder, const std::string& options = "--json") {
  return testing::RunProgram(testing::kBenchImu, "--data " + folder.string() + " " + options);
}

std::ostream& operator<<(std::ostream& stream, const Eigen::Vector3d& v) {
  return stream << ',' << v.x() << ',' << v.y() << ',' << v.z();
}

struct SequenceOptions {
  double duration = 6.0;  // [s]
  double tilt = 0.0;      // [rad] of the world, about x
  // [rad] per axis, errors of the true orientation that last for two seconds; velocity and position
  // are exact.
  double orientation_error = 0.0;
  ImuBias bias = ImuBias::Zero();
  bool poses_only = false;  // groundtruth.txt
};

// Writes the readings of a noise-free IMU on a motion with many rotations.
void WriteSequence(const std::filesystem::path& folder, const SequenceOptions& options = {}) {
  constexpr double kStep = 0.005, kLasting = 2.0;  // [s]
  const SinusoidalMotion motion;
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  const double keeps = std::exp(-kStep / kLasting);
  std::ofstream imu(folder / "imu.csv");
  std::ofstream truth(folder / (options.poses_only ? "groundtruth.txt" : "groundtruth.csv"));
  imu << "#timestamp [ns],w,w,w,a,a,a\n" << std::setprecision(15);
  truth << "#time(ns),p,p,p,q,q,q,q,v,v,v,bw,bw,bw,ba,ba,ba\n" << std::setprecision(15);
  for (const ImuSample& sample : motion.Samples(1.0 / kStep, options.duration)) {
    imu << sample.stamp << Eigen::Vector3d(sample.gyroscope + options.bias.head<3>())
        << Eigen::Vector3d(sample.accelerometer + options.bias.tail<3>()) << '\n';
    for (double& e : error) {
      e = keeps * e + options.orientation_error * std::sqrt(1.0 - keeps * keeps) * normal(rng);
    }
    const ImuState state = motion.StateAt(ToSeconds(sample.stamp));
    const Pose T_NW = Pose::FromTangent({1, 2, 3}, {options.tilt, 0, 0});
    const Pose exact = T_NW * state.T_WB;
    const Pose T_NB(exact.q() * so3::Exp(error), exact.p());
    const Eigen::Vector3d v_NB = T_NW.q() * state.v_WB;
    if (options.poses_only) {
      const Eigen::Vector4d q = T_NB.q().coeffs();
      truth << ToSeconds(sample.stamp) << ' ' << T_NB.p().transpose() << ' ' << q.transpose()
            << '\n';
    } else if (sample.stamp % 50'000'000 == 0) {
      truth << sample.stamp << T_NB.p() << ',' << T_NB.q().w() << Eigen::Vector3d(T_NB.q().vec())
            << v_NB << ",0,0,0,0,0,0\n";
    }
  }
}

TEST(BenchImu, PredictsAGeneratedMotionExactly) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path());
  const Outcome outcome = Bench(folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["windows"], 12);
  EXPECT_EQ(report["skipped"], 0);
  // The error is of fourth order at 200 Hz.
  EXPECT_LT(report["median_errors"]["position_m"], 1e-6);
  EXPECT_LT(report["median_errors"]["rotation_deg"], 1e-4);
  EXPECT_LT(report["normalised_by_imu"]["velocity"], 1e-4);
  EXPECT_LT(report["gravity_tilt_deg"], 1e-4);
}

TEST(BenchImu, FindsTheTiltOfTheGroundTruth) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path(), {.tilt = 0.01});
  const json report = json::parse(Bench(folder.path()).out);
  EXPECT_NEAR(report["gravity_tilt_deg"], 0.01 * 180.0 / M_PI, 1e-4);
  EXPECT_GT(report["median_errors"]["velocity_m_s"], 0.04);  // 0.01 * 9.81 * 0.5 s
  EXPECT_LT(report["median_errors_gravity_estimated"]["velocity_m_s"], 1e-4);
}

TEST(BenchImu, EstimatesAndCountsTheErrorOfGroundTruth) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path(), {.duration = 200.0, .orientation_error = 0.005});
  const json report = json::parse(Bench(folder.path()).out);
  // The statistics are over 12 windows of 16 s.
  EXPECT_NEAR(report["truth_noise"]["orientation_deg"], 0.005 * 180.0 / M_PI, 0.1);
  EXPECT_GT(report["normalised_by_imu"]["rotation"], 50.0);
  EXPECT_GT(report["normalised_by_imu"]["velocity"], 5.0);
  for (const char* part : {"rotation", "velocity", "position"}) {
    // The IMU is better than its stated noise, so that less than 1 remains.
    EXPECT_GT(report["normalised_by_both"][part], 0.4) << part;
    EXPECT_LT(report["normalised_by_both"][part], 1.4) << part;
  }
}

TEST(BenchImu, FindsBiasesAndVelocitiesWhereThereArePosesAlone) {
  const testing::TemporaryDirectory folder("imu");
  ImuBias bias;
  bias << 0.02, -0.03, 0.08, 0.1, -0.2, 0.05;
  WriteSequence(folder.path(), {.duration = 20.0, .bias = bias, .poses_only = true});
  const Outcome outcome = Bench(folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_LT(report["median_errors"]["rotation_deg"], 1e-3);
  // The velocity is the slope of a curved path over 0.1 s.
  EXPECT_LT(report["median_errors"]["velocity_m_s"], 0.02);
}

TEST(BenchImu, ExplainsTheErrorsOnRealRecordings) {
  const std::filesystem::path shared = testing::kSharedData;
  if (!std::filesystem::exists(shared / "real_imu")) GTEST_SKIP() << "needs shared/data";
  const auto expect_explained = [&](const char* folder, const char* noise, double most) {
    const json report = json::parse(Bench(shared / folder, std::string("--json") + noise).out);
    EXPECT_GT(report["windows"], 220);
    for (const char* part : {"rotation", "velocity", "position"}) {
      EXPECT_GT(report["normalised_by_imu"][part], 2.0) << folder << part;
      EXPECT_GT(report["normalised_by_both"][part], 0.7) << folder << part;
      EXPECT_LT(report["normalised_by_both"][part], most) << folder << part;
    }
  };
  // Hand-held, with the densities of its data sheet.
  expect_explained("real_imu/tum_vi_room1", " --noise 1.6e-4,2.8e-3,2.2e-5,8.6e-4", 1.5);
  // A drone: the densities of its IMU with the motors idling
  // (docs/imu_noise_estimation.md).
  expect_explained("euroc_v101", " --noise 5.7e-4,7.2e-3,1.9e-5,3e-3", 1.3);
  expect_explained("real_imu/euroc_v202", " --noise 5.7e-4,7.2e-3,1.9e-5,3e-3", 2.0);
}

TEST(BenchImu, NamesTheLineItCannotRead) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path());
  std::ofstream(folder.path() / "imu.csv", std::ios::app) << "12,oops\n";
  testing::ExpectRefused(Bench(folder.path()), 2, {"imu.csv:1203: expected a stamp and 6 numbers"});
  EXPECT_EQ(Bench("/nowhere").exit_code, 2);
  EXPECT_EQ(Bench(folder.path(), "--window -1").exit_code, 1);
}

}  // namespace
}  // namespace highwall::bench_imu_test
