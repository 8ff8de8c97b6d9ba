#include <highwall/core/trajectory.h>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/core/trajectory_log.h>

#include "support/file_size_limit.h"
#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::trajectory_test {
namespace {

namespace fs = std::filesystem;

class TrajectoryFile : public ::testing::Test {
 protected:
  fs::path Write(const std::string& text) const {
    const fs::path path = folder_ / "trajectory.txt";
    testing::WriteText(path, text);
    return path;
  }
  std::string MessageOf(const fs::path& path) const {
    return testing::MessageOf<IoError>([&] { ReadTumTrajectory(path); });
  }

  const testing::TemporaryDirectory folder_;
};

StampedPose At(double seconds, double x = 0.0) {
  return {FromSeconds(seconds), Pose(Eigen::Quaterniond::Identity(), {x, 0.0, 0.0})};
}

TEST_F(TrajectoryFile, ReadsCommentsBlankLinesTabsAndWindowsLineEnds) {
  const Trajectory trajectory =
      ReadTumTrajectory(Write("# stamp tx ty tz qx qy qz qw\n"
                              "\n"
                              "1305031102.175304 1 2 3 0 0 0 1\r\n"
                              "   \t \n"
                              "  # indented comment\n"
                              "\t1305031102.2\t+1.5  -2e-1 .25 0 0 2 0  "));
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_EQ(trajectory[0].stamp, 1305031102175304000);
  EXPECT_EQ(trajectory[0].pose.p(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(trajectory[1].stamp, 1305031102200000000);
  EXPECT_EQ(trajectory[1].pose.p(), Eigen::Vector3d(1.5, -0.2, 0.25));
  EXPECT_EQ(trajectory[1].pose.q().z(), 1.0) << "quaternions are normalised";
}

TEST_F(TrajectoryFile, WithoutAPoseIsAnEmptyTrajectory) {
  EXPECT_TRUE(ReadTumTrajectory(Write("# only a comment\n")).empty());
  EXPECT_TRUE(ReadTumTrajectory(Write("")).empty());
}

TEST_F(TrajectoryFile, MalformedLinesAreErrorsThatNameFileLineAndReason) {
  const std::string good = "1.0 0 0 0 0 0 0 1\n";
  const struct {
    std::string line;
    std::string reason;
  } cases[] = {
      {"2.0 0 0 0 0 0 1", "found 7 values"},
      {"2.0 0 0 0 0 0 0 1 5", "found 9 values"},
      {"2.0,0,0,0,0,0,0,1", "found 1 value"},
      {"2.0 0 zero 0 0 0 0 1", "ty 'zero' is not a number"},
      {"2.0 0 0 1.0x 0 0 0 1", "tz '1.0x' is not a number"},
      {"2.0 nan 0 0 0 0 0 1", "tx 'nan' is not a finite number"},
      {"2.0 0 0 0 0 0 0 NaN", "qw 'NaN' is not a finite number"},
      {"2.0 0 inf 0 0 0 0 1", "ty 'inf' is not a finite number"},
      {"2.0 0 0 1e999 0 0 0 1", "tz '1e999' is not a finite number"},
      {"2.0 0 0 0 0 0 0 0", "quaternion"},
      {"2.0 0 0 0 0 0 0 64e222", "quaternion"},
      {"nan 0 0 0 0 0 0 1", "stamp 'nan'"},
      {"two 0 0 0 0 0 0 1", "stamp 'two'"},
      {"0.5 0 0 0 0 0 0 1", "goes back in time"},
  };
  for (const auto& c : cases) {
    const fs::path path = Write(good + "# comment\n" + c.line + "\n" + good);
    const std::string message = MessageOf(path);
    EXPECT_TRUE(message.starts_with(path.string() + ":3: ")) << message;
    EXPECT_NE(message.find(c.reason), std::string::npos) << message;
  }
}

TEST_F(TrajectoryFile, MissingFilesAndFoldersAreErrors) {
  EXPECT_NE(MessageOf(folder_ / "none.txt").find("none.txt: cannot be opened"), std::string::npos);
  EXPECT_NE(MessageOf(folder_.path()).find("is a folder"), std::string::npos);
}

TEST_F(TrajectoryFile, EqualStampsAreAccepted) {
  EXPECT_EQ(ReadTumTrajectory(Write("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n")).size(), 2u);
}

TEST_F(TrajectoryFile, ComesBackAsItWasWritten) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Trajectory written;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Quaterniond q(u(rng), u(rng), u(rng), u(rng));
    written.push_back({1305031102175304123 + Stamp{33'333'333} * i,
                       Pose(q, 1e3 * Eigen::Vector3d(u(rng), u(rng), 0))});
  }
  const fs::path path = folder_ / "out.txt";
  WriteTumTrajectory(path, written);
  const Trajectory read = ReadTumTrajectory(path);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].stamp, written[i].stamp);
    for (int k = 0; k < Pose::kSize; ++k) {
      EXPECT_NEAR(read[i].pose.data()[k], written[i].pose.data()[k], 1e-9);
    }
  }
}

TEST_F(TrajectoryFile, IsLeftAloneWhenTheNewOneCannotBeWritten) {
  const fs::path path = Write("old\n");
  Trajectory broken = {At(1.0), At(2.0)};
  broken[1].pose.data()[0] = std::nan("");
  EXPECT_THROW(WriteTumTrajectory(path, broken), InvalidArgument);
  EXPECT_THROW(WriteTumTrajectory(path, {At(2.0), At(1.0)}), InvalidArgument);
  EXPECT_EQ(testing::ReadText(path), "old\n");
  EXPECT_EQ(folder_.FileCount(), 1U);
  EXPECT_THROW(WriteTumTrajectory(folder_ / "no" / "out.txt", {}), IoError);
}

TEST(MatchByStamp, FindsTheNearestPoseOfTheLongerTrajectory) {
  const Trajectory reference = {At(0.0), At(1.0), At(2.0), At(3.0)};
  const Trajectory estimate = {At(0.9), At(1.6), At(9.0)};
  const auto matches = MatchByStamp(reference, estimate, FromSeconds(0.45));
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].reference, 1u);
  EXPECT_EQ(matches[0].estimate, 0u);
  EXPECT_EQ(matches[1].reference, 2u);
  EXPECT_EQ(matches[1].estimate, 1u);

  const auto swapped = MatchByStamp(estimate, reference, FromSeconds(0.45));
  ASSERT_EQ(swapped.size(), 2u);
  EXPECT_EQ(swapped[1].reference, 1u);
  EXPECT_EQ(swapped[1].estimate, 2u);
}

TEST(MatchByStamp, TakesTheEarlierOfTwoThatAreEquallyNearAndTheFirstOfEqualStamps) {
  const Trajectory reference = {At(0.0), At(1.0), At(1.0), At(2.0)};
  EXPECT_EQ(MatchByStamp(reference, {At(1.5)}, FromSeconds(1.0))[0].reference, 1u);
  EXPECT_EQ(MatchByStamp(reference, {At(1.1)}, FromSeconds(1.0))[0].reference, 1u);
}

TEST(MatchByStamp, ToleranceIsInclusiveToTheNanosecond) {
  const Trajectory reference = {At(1.00), At(5.0)};
  EXPECT_EQ(MatchByStamp(reference, {At(1.02)}, FromSeconds(0.02)).size(), 1u);
  EXPECT_EQ(MatchByStamp(reference, {At(1.02)}, FromSeconds(0.02) - 1).size(), 0u);
}

TEST(MatchByStamp, AgreesWithExhaustiveSearch) {
  std::mt19937 rng(3);
  std::uniform_int_distribution<Stamp> step(0, 20'000'000);
  Trajectory reference, estimate;
  Stamp stamp = 1'305'031'102'000'000'000;
  for (int i = 0; i < 900; ++i) reference.push_back({stamp += step(rng), Pose()});
  stamp = 1'305'031'102'000'000'000;
  for (int i = 0; i < 250; ++i) estimate.push_back({stamp += 2 * step(rng), Pose()});
  const Stamp tolerance = 4'000'000;
  std::vector<std::pair<std::size_t, std::size_t>> expected;
  for (std::size_t e = 0; e < estimate.size(); ++e) {
    std::size_t best = 0;
    for (std::size_t r = 1; r < reference.size(); ++r) {
      const auto distance = [&](std::size_t k) {
        return std::abs(reference[k].stamp - estimate[e].stamp);
      };
      if (distance(r) < distance(best)) best = r;
    }
    if (std::abs(reference[best].stamp - estimate[e].stamp) <= tolerance) {
      expected.emplace_back(best, e);
    }
  }
  ASSERT_GT(expected.size(), 50u);
  ASSERT_LT(expected.size(), estimate.size());
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (const StampMatch& match : MatchByStamp(reference, estimate, tolerance)) {
    found.emplace_back(match.reference, match.estimate);
  }
  EXPECT_EQ(found, expected);
}

TEST(MatchByStamp, EmptyTrajectoriesMatchNothing) {
  EXPECT_TRUE(MatchByStamp({}, {}, 1).empty());
  EXPECT_TRUE(MatchByStamp({At(1.0)}, {}, 1).empty());
  EXPECT_TRUE(MatchByStamp({}, {At(1.0)}, 1).empty());
}

TEST(MatchByStamp, RefusesDecreasingStampsAndNegativeTolerance) {
  EXPECT_THROW(MatchByStamp({At(2.0), At(1.0)}, {At(1.0)}, 1), InvalidArgument);
  EXPECT_THROW(MatchByStamp({At(1.0)}, {At(2.0), At(1.0)}, 1), InvalidArgument);
  EXPECT_THROW(MatchByStamp({At(1.0)}, {At(1.0)}, -1), InvalidArgument);
}

TEST(Interpolate, MovesLinearlyAndTurnsAtConstantRate) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();
  const Trajectory trajectory = {{FromSeconds(10.0), Pose(so3::Exp(0.2 * axis), {1.0, 0.0, 0.0})},
                                 {FromSeconds(12.0), Pose(so3::Exp(1.0 * axis), {2.0, 4.0, -8.0})}};
  const auto pose = Interpolate(trajectory, FromSeconds(10.5));
  ASSERT_TRUE(pose.has_value());
  // Rounding of one slerp.
  EXPECT_TRUE(pose->p().isApprox(Eigen::Vector3d(1.25, 1.0, -2.0), 1e-14));
  EXPECT_TRUE(so3::Log(pose->q()).isApprox(0.4 * axis, 1e-13));
}

TEST(Interpolate, GivesThePosesThemselvesAndNothingOutside) {
  const Trajectory trajectory = {At(1.0, 5.0), At(2.0, 6.0), At(2.0, 7.0), At(3.0, 8.0)};
  EXPECT_EQ(Interpolate(trajectory, FromSeconds(1.0))->p().x(), 5.0);
  EXPECT_EQ(Interpolate(trajectory, FromSeconds(2.0))->p().x(), 6.0);
  EXPECT_EQ(Interpolate(trajectory, FromSeconds(2.5))->p().x(), 7.5);
  EXPECT_EQ(Interpolate(trajectory, FromSeconds(3.0))->p().x(), 8.0);
  EXPECT_FALSE(Interpolate(trajectory, FromSeconds(1.0) - 1).has_value());
  EXPECT_FALSE(Interpolate(trajectory, FromSeconds(3.0) + 1).has_value());
  EXPECT_FALSE(Interpolate({}, 0).has_value());
}

// The content of the file while the log is open is the content after the process is killed.
TEST_F(TrajectoryFile, ALogIsWholeAfterEachPoseAndEqualsAFileWrittenAtOnce) {
  const fs::path path = folder_ / "log.txt", whole = folder_ / "whole.txt";
  testing::WriteText(path, "of an earlier run, and longer than a line");
  TrajectoryLog log(path);
  EXPECT_TRUE(ReadTumTrajectory(path).empty());
  Trajectory trajectory;
  for (const double seconds : {1.0, 1.5, 1.5, 2.0}) {
    trajectory.push_back(At(seconds, 0.1 * seconds));
    log.Append(trajectory.back());
    WriteTumTrajectory(whole, trajectory);
    EXPECT_EQ(testing::ReadText(path), testing::ReadText(whole));
  }
  EXPECT_THROW(log.Append(At(1.9)), InvalidArgument);
  EXPECT_THROW(log.Append(At(2.1, std::nan(""))), InvalidArgument);
  EXPECT_EQ(testing::ReadText(path), testing::ReadText(whole));
}

TEST_F(TrajectoryFile, ALogOnAFullDiskNamesTheFaultAndTheFile) {
  const fs::path path = folder_ / "log.txt";
  const testing::FileSizeLimit limit(1024);
  TrajectoryLog log(path);
  std::string message;
  std::size_t written = 0;
  for (; written < 100 && message.empty(); ++written) {
    try {
      log.Append(At(static_cast<double>(written)));
    } catch (const IoError& error) {
      message = error.what();
    }
  }
  EXPECT_EQ(message, path.string() + ": could not be written: File too large");
  EXPECT_THROW(log.Append(At(1000.0)), IoError);
  EXPECT_EQ(ReadTumTrajectory(path).size(), written - 1) << "no part of a line";
  EXPECT_THROW(TrajectoryLog(folder_ / "missing" / "log.txt"), IoError);
}

}  // namespace
}  // namespace highwall::trajectory_test
