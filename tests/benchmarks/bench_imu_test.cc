// Runs highwall_bench_imu as a user does: on a generated motion, and on EuRoC where it is at hand.
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/imu_scene.h"
#include "support/run_program.h"

namespace highwall {
namespace {

using nlohmann::json;
using testing::Outcome;

Outcome Bench(const std::filesystem::path& folder, const std::string& options = "--json") {
  return testing::RunProgram(HIGHWALL_BENCH_IMU, "--data " + folder.string() + " " + options);
}

std::ostream& operator<<(std::ostream& stream, const Eigen::Vector3d& v) {
  return stream << ',' << v.x() << ',' << v.y() << ',' << v.z();
}

// Six seconds without noise or bias, in a world that is tilted by `tilt` about x [rad].
void WriteSequence(const std::filesystem::path& folder, double tilt) {
  const SinusoidalMotion motion;
  std::ofstream imu(folder / "imu.csv"), truth(folder / "groundtruth.csv");
  imu << "#timestamp [ns],w,w,w,a,a,a\n" << std::setprecision(15);
  truth << "#time(ns),p,p,p,q,q,q,q,v,v,v,bw,bw,bw,ba,ba,ba\n" << std::setprecision(15);
  for (const ImuSample& sample : motion.Samples(200.0, 6.0)) {
    imu << sample.stamp << sample.gyroscope << sample.accelerometer << '\n';
    if (sample.stamp % 50'000'000 != 0) continue;
    const ImuState state = motion.StateAt(ToSeconds(sample.stamp));
    const Pose T_NW = Pose::FromTangent({1, 2, 3}, {tilt, 0, 0});
    const Pose T_NB = T_NW * state.T_WB;
    const Eigen::Vector3d v_NB = T_NW.q() * state.v_WB;
    truth << sample.stamp << T_NB.p() << ',' << T_NB.q().w() << Eigen::Vector3d(T_NB.q().vec())
          << v_NB << ",0,0,0,0,0,0\n";
  }
}

TEST(BenchImu, PredictsAGeneratedMotionExactly) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path(), 0.0);
  const Outcome outcome = Bench(folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["windows"], 12);
  EXPECT_EQ(report["skipped"], 0);
  // Fourth order at 200 Hz.
  EXPECT_LT(report["median_errors"]["position_m"], 1e-6);
  EXPECT_LT(report["median_errors"]["rotation_deg"], 1e-4);
  EXPECT_LT(report["median_errors"]["normalised_velocity"], 1e-4);
  EXPECT_LT(report["gravity_tilt_deg"], 1e-4);
}

TEST(BenchImu, FindsTheTiltOfTheGroundTruth) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path(), 0.01);
  const json report = json::parse(Bench(folder.path()).out);
  EXPECT_NEAR(report["gravity_tilt_deg"], 0.01 * 180.0 / M_PI, 1e-4);
  EXPECT_GT(report["median_errors"]["velocity_m_s"], 0.04);  // 0.01 * 9.81 * 0.5 s
  EXPECT_LT(report["median_errors_gravity_estimated"]["velocity_m_s"], 1e-4);
}

TEST(BenchImu, PredictsEurocAsWellAsItsGroundTruthAllows) {
  const std::filesystem::path folder = HIGHWALL_SHARED_DATA "/euroc_v101";
  if (!std::filesystem::exists(folder / "imu.csv")) GTEST_SKIP() << "needs shared/data/euroc_v101";
  const json report = json::parse(Bench(folder).out);
  EXPECT_GT(report["windows"], 250);
  const json& errors = report["median_errors_gravity_estimated"];
  EXPECT_LT(errors["rotation_deg"], 0.07);
  EXPECT_LT(errors["velocity_m_s"], 0.02);
  EXPECT_LT(errors["position_m"], 0.005);
}

TEST(BenchImu, NamesTheLineItCannotRead) {
  const testing::TemporaryDirectory folder("imu");
  WriteSequence(folder.path(), 0.0);
  std::ofstream(folder.path() / "imu.csv", std::ios::app) << "12,oops\n";
  testing::ExpectRefused(Bench(folder.path()), 2, {"imu.csv:1203: expected a stamp and 6 numbers"});
  EXPECT_EQ(Bench("/nowhere").exit_code, 2);
  EXPECT_EQ(Bench(folder.path(), "--window -1").exit_code, 1);
}

}  // namespace
}  // namespace highwall
