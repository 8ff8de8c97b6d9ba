#include <highwall/core/trajectory_error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::trajectory_error_test {
namespace {

// Rounding of a few products of poses of magnitude 10.
constexpr double kRounding = 1e-13;

// Poses 0.1 s apart on a curved path that rotates about a changing axis.
Trajectory BentPath(int poses) {
  Trajectory trajectory;
  for (int i = 0; i < poses; ++i) {
    const double t = 0.1 * i;
    trajectory.push_back({FromSeconds(t), Pose(so3::Exp({0.3 * std::sin(t), 0.2 * t, 0.1}),
                                               {t, std::sin(t), 0.3 * std::cos(2.0 * t)})});
  }
  return trajectory;
}

// Poses 1 s apart on the x axis, at a spacing of `step` metres.
Trajectory StraightPath(int poses, double step) {
  Trajectory trajectory;
  for (int i = 0; i < poses; ++i) {
    trajectory.push_back(
        {FromSeconds(i), Pose(Eigen::Quaterniond::Identity(), {step * i, 0.0, 0.0})});
  }
  return trajectory;
}

// Replaces every pose T of the trajectory by T_AB * T.
Trajectory Moved(const Pose& T_AB, Trajectory trajectory) {
  for (StampedPose& stamped : trajectory) stamped.pose = T_AB * stamped.pose;
  return trajectory;
}

Pose SomePose() {
  return Pose(Eigen::Quaterniond(0.2, -0.7, 0.5, 0.1), {-4.0, 0.5, 9.0});
}

template <typename Function>
std::string MessageOf(const Function& function) {
  try {
    function();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "no error";
}

TEST(ComputeStatistics, MatchesHandComputation) {
  const ErrorStatistics s = ComputeStatistics({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(s.min, 1.0);
  EXPECT_EQ(s.max, 4.0);
  EXPECT_EQ(s.mean, 2.5);
  EXPECT_EQ(s.median, 2.5);
  EXPECT_EQ(s.sse, 30.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_EQ(ComputeStatistics({5.0, 1.0, 2.0}).median, 2.0);
  EXPECT_THROW(ComputeStatistics({}), InvalidArgument);
}

TEST(AlignUmeyama, RecoversASimilarity) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Pose T = SomePose();
  const Eigen::Matrix3Xd b = Eigen::Matrix3Xd::NullaryExpr(3, 20, [&] { return u(rng); });
  const Eigen::Matrix3Xd a = (1.7 * T.R() * b).colwise() + T.p();
  const Similarity found = *AlignUmeyama(a, b, true);
  EXPECT_NEAR(found.scale, 1.7, kRounding);
  EXPECT_TRUE(found.T_AB.R().isApprox(T.R(), kRounding));
  EXPECT_TRUE(found.T_AB.p().isApprox(T.p(), kRounding));
  EXPECT_EQ(AlignUmeyama(a, b, false)->scale, 1.0);
}

TEST(AlignUmeyama, OfMirroredPointsIsTheBestRotationAndNoReflection) {
  std::mt19937 rng(12);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Eigen::Matrix3Xd b = Eigen::Matrix3Xd::NullaryExpr(3, 20, [&] { return u(rng); });
  const Eigen::Matrix3Xd a = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal() * b;
  const Similarity best = *AlignUmeyama(a, b, false);
  const auto cost = [&](const Pose& T) { return (a - ((T.R() * b).colwise() + T.p())).norm(); };
  for (int i = 0; i < 100; ++i) {
    Eigen::Matrix<double, 6, 1> step;
    for (double& value : step) value = 0.01 * u(rng);
    EXPECT_GT(cost(best.T_AB.Plus(step)), cost(best.T_AB));
  }
}

TEST(AlignUmeyama, IsEmptyForPointsThatDoNotFixTheRotation) {
  const Eigen::Matrix3Xd line = Eigen::Vector3d(1.0, 2.0, 3.0) * Eigen::RowVector4d(0, 1, 2, 4);
  const Eigen::Matrix3Xd point = Eigen::Matrix3Xd::Ones(3, 5);
  const Eigen::Matrix3Xd two = Eigen::Matrix3Xd::Identity(3, 2);
  for (const bool with_scale : {false, true}) {
    EXPECT_FALSE(AlignUmeyama(line, line, with_scale));
    EXPECT_FALSE(AlignUmeyama(point, point, with_scale));
    EXPECT_FALSE(AlignUmeyama(two, two, with_scale));
  }
}

TEST(AlignUmeyama, RefusesSidesOfDifferentSizes) {
  const Eigen::Matrix3Xd line = Eigen::Vector3d(1.0, 2.0, 3.0) * Eigen::RowVector4d(0, 1, 2, 4);
  EXPECT_THROW(AlignUmeyama(line, line.leftCols(3), false), InvalidArgument);
}

// A track along the x axis, rotated and translated. The estimate deviates from the line to both
// sides alternately, so that neither its mean nor its direction changes.
TEST(AbsolutePoseError, OfAStraightTrackIsDeterminedByPositionsAndAttitudesTogether) {
  const Trajectory straight = StraightPath(8, 0.5);
  Trajectory beside = straight;
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const double side = i % 4 == 0 || i % 4 == 3 ? 0.1 : -0.1;
    beside[i].pose = Pose(beside[i].pose.q(), beside[i].pose.p() + Eigen::Vector3d(0, side, 0));
  }
  const Pose T = SomePose();
  for (const auto alignment : {TrajectoryAlignment::kSe3, TrajectoryAlignment::kSim3}) {
    for (const bool off : {false, true}) {
      // A scale compensates for a part of the lateral deviation.
      if (off && alignment == TrajectoryAlignment::kSim3) continue;
      const auto error = [&](PoseRelation relation) {
        return AbsolutePoseError(straight, Moved(T, off ? beside : straight),
                                 {.alignment = alignment, .relation = relation});
      };
      const TrajectoryError translation = error(PoseRelation::kTranslation);
      EXPECT_EQ(translation.open_rotation, OpenRotation::kAboutLine);
      for (const double e : translation.errors) EXPECT_NEAR(e, off ? 0.1 : 0.0, 10 * kRounding);
      EXPECT_LT(error(PoseRelation::kAngleDegrees).statistics.max, 1e-5);
    }
  }
  // Each pose is rotated about the line: the attitudes determine the alignment by their mean.
  Trajectory rolling = straight;
  for (std::size_t i = 0; i < rolling.size(); ++i) {
    rolling[i].pose =
        Pose(so3::Exp({0.3 + (i % 2 == 0 ? 0.02 : -0.02), 0, 0}), rolling[i].pose.p());
  }
  const TrajectoryError roll =
      AbsolutePoseError(straight, Moved(T, rolling), {.relation = PoseRelation::kAngleDegrees});
  for (const double e : roll.errors) EXPECT_NEAR(e, 0.02 * 180.0 / M_PI, 1e-10);
}

TEST(AbsolutePoseError, OfABodyAtRestIsAlignedByItsAttitudes) {
  Trajectory rest = StraightPath(8, 0.0);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    rest[i].pose = Pose(so3::Exp({0.1 * static_cast<double>(i), 0.2, 0}), rest[i].pose.p());
  }
  const Trajectory moved = Moved(SomePose(), rest);
  const TrajectoryError error =
      AbsolutePoseError(rest, moved, {.relation = PoseRelation::kAngleDegrees});
  EXPECT_EQ(error.open_rotation, OpenRotation::kAll);
  EXPECT_LT(error.statistics.max, 1e-5);
  EXPECT_THROW(AbsolutePoseError(rest, moved, {.alignment = TrajectoryAlignment::kSim3}),
               InvalidArgument);
}

TEST(AbsolutePoseError, OfABentPathLeavesNothingOpen) {
  const Trajectory path = BentPath(20);
  EXPECT_EQ(AbsolutePoseError(path, Moved(SomePose(), path)).open_rotation, OpenRotation::kNone);
}

TEST(AbsolutePoseError, WithoutAlignmentIsThePoseDifference) {
  const Trajectory reference = BentPath(30);
  // The body frame rotates by half a turn about z, and the world frame is translated.
  Trajectory estimate = reference;
  const Pose turn(Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0), Eigen::Vector3d::Zero());
  for (StampedPose& stamped : estimate) {
    const Pose turned = stamped.pose * turn;
    stamped.pose = Pose(turned.q(), turned.p() + Eigen::Vector3d(2.0, -1.0, 2.0));
  }
  const auto mean = [&](PoseRelation relation) {
    return AbsolutePoseError(reference, estimate,
                             {.alignment = TrajectoryAlignment::kNone, .relation = relation})
        .statistics.mean;
  };
  EXPECT_NEAR(mean(PoseRelation::kTranslation), 3.0, kRounding);
  EXPECT_NEAR(mean(PoseRelation::kAngleDegrees), 180.0,
              1e-6);  // acos near pi loses half the digits
  // E - I = [diag(-2, -2, 0), t] with |t| = 3.
  EXPECT_NEAR(mean(PoseRelation::kFull), std::sqrt(4.0 + 4.0 + 9.0), kRounding);
}

TEST(AbsolutePoseError, AlignmentTakesAwayAMoveOfTheWorld) {
  const Trajectory reference = BentPath(50);
  const Trajectory moved = Moved(SomePose(), reference);
  for (const auto alignment :
       {TrajectoryAlignment::kSe3, TrajectoryAlignment::kSim3, TrajectoryAlignment::kOrigin}) {
    const TrajectoryError result = AbsolutePoseError(
        reference, moved, {.alignment = alignment, .relation = PoseRelation::kFull});
    EXPECT_LT(result.statistics.max, 1e-12);
    EXPECT_NEAR(result.scale, 1.0, kRounding);
  }
  EXPECT_GT(
      AbsolutePoseError(reference, moved, {.alignment = TrajectoryAlignment::kNone}).statistics.min,
      1.0);
}

TEST(AbsolutePoseError, Sim3FindsTheScaleAndSe3LeavesIt) {
  const Trajectory reference = BentPath(50);
  Trajectory shrunk = reference;
  for (StampedPose& stamped : shrunk) {
    stamped.pose = Pose(stamped.pose.q(), 0.8 * stamped.pose.p());
  }
  const auto error = [&](TrajectoryAlignment alignment) {
    return AbsolutePoseError(reference, shrunk, {.alignment = alignment});
  };
  EXPECT_NEAR(error(TrajectoryAlignment::kSim3).scale, 1.25, kRounding);
  EXPECT_LT(error(TrajectoryAlignment::kSim3).statistics.max, kRounding);
  EXPECT_EQ(error(TrajectoryAlignment::kSe3).scale, 1.0);
  EXPECT_GT(error(TrajectoryAlignment::kSe3).statistics.rmse, 0.1);
}

TEST(AbsolutePoseError, ScaleAloneMultipliesPositionsAndMovesNothing) {
  const Trajectory reference = BentPath(50);
  Trajectory shrunk = reference;
  for (StampedPose& stamped : shrunk) {
    stamped.pose = Pose(stamped.pose.q(), 0.8 * stamped.pose.p());
  }
  const TrajectoryError here =
      AbsolutePoseError(reference, shrunk, {.alignment = TrajectoryAlignment::kScale});
  EXPECT_NEAR(here.scale, 1.25, kRounding);
  EXPECT_LT(here.statistics.max, kRounding);
  const Pose away = SomePose();
  const TrajectoryError moved =
      AbsolutePoseError(reference, Moved(away, shrunk), {.alignment = TrajectoryAlignment::kScale});
  EXPECT_NEAR(moved.scale, 1.25, kRounding);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Eigen::Vector3d expected = 1.25 * (away * shrunk[i].pose.p());
    EXPECT_LT((moved.estimate[i].pose.p() - expected).norm(), kRounding);
  }
}

TEST(RelativePoseError, CountsFramesFromEveryPoseOrOneAfterTheOther) {
  const Trajectory reference = StraightPath(11, 1.0);
  const Trajectory estimate = StraightPath(11, 1.1);  // 10 % too long
  const TrajectoryError consecutive = RelativePoseError(reference, estimate, {.delta = 3.0});
  EXPECT_EQ(consecutive.indices, (std::vector<std::size_t>{3, 6, 9}));
  EXPECT_NEAR(consecutive.statistics.min, 0.3, kRounding);
  EXPECT_NEAR(consecutive.statistics.max, 0.3, kRounding);
  const TrajectoryError all =
      RelativePoseError(reference, estimate, {.delta = 3.0, .all_pairs = true});
  EXPECT_EQ(all.indices, (std::vector<std::size_t>{3, 4, 5, 6, 7, 8, 9, 10}));
}

TEST(RelativePoseError, CountsMetresAlongTheEstimate) {
  const Trajectory reference = StraightPath(11, 1.0);
  const Trajectory estimate = StraightPath(11, 0.5);
  RelativePoseErrorOptions options{.delta = 1.0, .delta_unit = DeltaUnit::kMetres};
  // Cut at the poses 2, 4, 6, 8, 10; the first piece is the run-up.
  EXPECT_EQ(RelativePoseError(reference, estimate, options).indices,
            (std::vector<std::size_t>{4, 6, 8, 10}));
  options.all_pairs = true;
  const TrajectoryError all = RelativePoseError(reference, estimate, options);
  EXPECT_EQ(all.indices, (std::vector<std::size_t>{2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_NEAR(all.statistics.mean, 1.0, kRounding);
}

TEST(RelativePoseError, AllPairsInMetresKeepsPathsWithinATenthOfDelta) {
  const Trajectory path = StraightPath(11, 1.0);
  const auto count = [&](double delta) {
    return RelativePoseError(path, path,
                             {.delta = delta, .delta_unit = DeltaUnit::kMetres, .all_pairs = true})
        .errors.size();
  };
  EXPECT_EQ(count(3.2), 8u);  // 3 m is close enough
  EXPECT_EQ(count(9.5), 2u);  // 9 m from the first two poses
  EXPECT_THROW(count(1.4), InvalidArgument);
}

TEST(RelativePoseError, DoesNotChangeWhenEitherWorldMoves) {
  const Trajectory reference = BentPath(60);
  std::mt19937 rng(5);
  std::normal_distribution<double> noise(0.0, 0.02);
  Trajectory estimate = reference;
  for (StampedPose& stamped : estimate) {
    Eigen::Matrix<double, 6, 1> step;
    for (double& value : step) value = noise(rng);
    stamped.pose = stamped.pose.Plus(step);
  }
  const RelativePoseErrorOptions options{.relation = PoseRelation::kFull, .delta = 2.0};
  const double rmse = RelativePoseError(reference, estimate, options).statistics.rmse;
  EXPECT_GT(rmse, 0.01);
  EXPECT_NEAR(RelativePoseError(Moved(SomePose(), reference), Moved(SomePose().Inverse(), estimate),
                                options)
                  .statistics.rmse,
              rmse, kRounding);
}

TEST(RelativePoseError, AllPairsOfALongTrajectoryThatStandsStillIsNotQuadratic) {
  Trajectory path = StraightPath(100, 0.1);
  const Pose rest = path.back().pose;
  for (int i = 0; i < 100'000; ++i) path.push_back({path.back().stamp + 1'000'000, rest});
  const TrajectoryError result = RelativePoseError(
      path, path, {.delta = 0.1, .delta_unit = DeltaUnit::kMetres, .all_pairs = true});
  EXPECT_EQ(result.errors.size(), 99u);
}

TEST(TimeCovered, IsTheShareOfTheReferenceTimeThatTheEstimateCovers) {
  Trajectory reference;  // 100 Hz over 20 s
  for (int i = 0; i <= 2000; ++i) reference.push_back({FromSeconds(0.01 * i), Pose()});
  const auto covered = [&](double from, double to, double lost_from, double lost_to) {
    Trajectory estimate;  // 20 Hz
    for (int i = 0; i <= 400; ++i) {
      const double t = 0.05 * i;
      if (t < from || t > to || (t > lost_from && t < lost_to)) continue;
      estimate.push_back({FromSeconds(t), Pose()});
    }
    return AbsolutePoseError(reference, estimate, {.alignment = TrajectoryAlignment::kNone})
        .time_covered;
  };
  EXPECT_NEAR(covered(0.0, 20.0, 9.0, 9.0), 1.0, 1e-9);
  EXPECT_NEAR(covered(0.0, 10.0, 9.0, 9.0), 0.5, 0.003);  // to one of 400 intervals
  EXPECT_NEAR(covered(0.0, 20.0, 5.0, 10.0), 0.75, 0.003);
  EXPECT_NEAR(covered(0.0, 20.0, 5.0, 5.11), 1.0, 1e-9);  // two lost frames do not count as a gap
}

TEST(TimeCovered, LeavesOutTheTimeInWhichTheReferenceIsBlind) {
  Trajectory reference, estimate;
  for (int i = 0; i <= 2000; ++i) {
    const StampedPose stamped{FromSeconds(0.01 * i), Pose()};
    if (i < 500 || i > 1200) reference.push_back(stamped);
    if (i % 5 == 0 && i <= 1600) estimate.push_back(stamped);
  }
  // The reference covers 5 + 8 s, of which the estimate covers 5 + 4 s.
  EXPECT_NEAR(AbsolutePoseError(reference, estimate, {.alignment = TrajectoryAlignment::kNone})
                  .time_covered,
              9.0 / 13.0, 0.01);
}

TEST(TrajectoryError, SaysWhyNothingMatches) {
  Trajectory later = BentPath(5);
  for (StampedPose& stamped : later) stamped.stamp += FromSeconds(100.0);
  const std::string message = MessageOf([&] { AbsolutePoseError(BentPath(5), later); });
  EXPECT_NE(message.find("no stamps match within 0.020000 s"), std::string::npos) << message;
  EXPECT_NE(message.find("100.000000 to 100.400000"), std::string::npos) << message;
  EXPECT_NE(MessageOf([&] { AbsolutePoseError({}, later); }).find("holds no pose"),
            std::string::npos);
}

TEST(TrajectoryError, SaysThatNoPairIsFarEnoughApart) {
  const Trajectory path = StraightPath(4, 1.0);
  const auto message = [&](const RelativePoseErrorOptions& options) {
    return MessageOf([&] { RelativePoseError(path, path, options); });
  };
  EXPECT_NE(message({.delta = 4.0}).find("frames apart"), std::string::npos);
  EXPECT_NE(message({.delta = 4.0, .delta_unit = DeltaUnit::kMetres}).find("m apart"),
            std::string::npos);
}

TEST(TrajectoryError, OptionsOutOfRangeAreNamed) {
  const Trajectory path = BentPath(5);
  const auto message = [&](const RelativePoseErrorOptions& options) {
    return MessageOf([&] { RelativePoseError(path, path, options); });
  };
  EXPECT_NE(message({.t_max_diff = -1.0}).find("t_max_diff"), std::string::npos);
  EXPECT_NE(message({.t_max_diff = std::nan("")}).find("t_max_diff"), std::string::npos);
  EXPECT_NE(message({.delta = 0.0}).find("delta"), std::string::npos);
  EXPECT_NE(message({.delta = 1.5}).find("whole number"), std::string::npos);
  EXPECT_THROW(AbsolutePoseError(path, path, {.t_max_diff = -1.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::trajectory_error_test
