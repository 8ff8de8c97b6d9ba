// The program of docs/tutorial_odometry.md, between the two marks, and its test.
// [tutorial]
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/core/sliding_window_smoother.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

// A point of your tracker: the same number in every image that shows it.
struct TrackedPoint {
  int landmark;                    // >= 0
  highwall::PointFeature feature;  // uv [px] without distortion, depth [m] or 0
};

// Visual odometry: the pose of each image by the landmarks so far, then a window of poses and
// landmarks together.
class Odometry {
 public:
  explicit Odometry(const highwall::RgbdSensor& sensor) : model_(sensor, {}) {}

  // T_WC of the image, in the camera frame of the first one; empty where too few points match.
  std::optional<highwall::Pose> AddImage(highwall::Stamp stamp, std::vector<TrackedPoint> seen) {
    using namespace highwall;
    std::erase_if(landmarks_, [this](const auto& l) { return !smoother_.Contains(l.second); });
    PerKind<PoseObservations> known;
    std::vector<TrackedPoint*> matched;
    for (TrackedPoint& o : seen) {
      o.feature.depth_sigma = model_.depth_noise().Sigma(o.feature.depth);
      if (!landmarks_.contains(o.landmark)) continue;
      known.points.push_back({smoother_.Value(landmarks_.at(o.landmark)), model_.Rows(o.feature),
                              MeasurementModel::Dimension(o.feature)});
      matched.push_back(&o);
    }
    if (started_) {
      const auto solution = SolvePose(T_WC_, model_.projection(), known);
      if (!solution) return std::nullopt;
      T_WC_ = solution->T_WC;
      for (std::size_t i = 0; i < known.points.size(); ++i) {
        if (!solution->inliers.points[i]) matched[i]->landmark = -1;
      }
    }
    const Variable<Pose> pose = smoother_.AddState(stamp, T_WC_);
    if (!started_) smoother_.Fix(pose);
    started_ = true;
    for (const auto& [landmark, feature] : seen) {
      if (landmark < 0) continue;  // a wrong match
      if (!landmarks_.contains(landmark)) {
        if (!(feature.depth > 0.0)) continue;
        landmarks_[landmark] = smoother_.AddLandmark(
            Point(T_WC_ * model_.camera().Unproject(feature.uv, feature.depth)));
      }
      smoother_.AddFactorToBlocks(model_.MakeFactor(feature),
                                  std::make_shared<ceres::HuberLoss>(2.4),
                                  std::vector<VariableId>{pose, landmarks_.at(landmark)});
    }
    if (!smoother_.Update().accepted) return std::nullopt;
    return T_WC_ = smoother_.Value(pose);
  }

 private:
  const highwall::MeasurementModel model_;
  highwall::SlidingWindowSmoother smoother_;
  std::map<int, highwall::Variable<highwall::Point>> landmarks_;
  bool started_ = false;
  highwall::Pose T_WC_;
};
// [/tutorial]

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace highwall {
namespace {

class OdometryTutorial : public ::testing::Test {
 protected:
  OdometryTutorial() {
    std::uniform_real_distribution<double> x(-4.0, 4.0), y(-2.0, 2.0), z(2.0, 6.0);
    for (int i = 0; i < 400; ++i) {
      const double u = x(rng_), v = y(rng_), w = z(rng_);
      points_.push_back({u, v, w});
    }
  }
  // The camera moves sideways and turns to and fro.
  static Pose At(int k) {
    return Pose::FromTangent({0.02 * k, 0.05 * std::sin(0.2 * k), 0.01 * k},
                             {0.0, 0.1 * std::sin(0.1 * k), 0.02 * std::sin(0.3 * k)});
  }
  // Returns the visible points with the noise of the sensor; every tenth is a wrong match.
  std::vector<TrackedPoint> See(int k, bool with_depth = true) {
    const PinholeCamera& camera = sensor_.camera;
    const Pose T_CW = (At(0).Inverse() * At(k)).Inverse();
    std::vector<TrackedPoint> seen;
    std::normal_distribution<double> noise;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p_C = T_CW * points_[i];
      if (p_C.z() < 0.5 || !camera.Contains(camera.Project(p_C), 2.0)) continue;
      PointFeature feature;
      const double u = 0.5 * noise(rng_), v = 0.5 * noise(rng_);
      feature.uv = camera.Project(p_C) + Eigen::Vector2d(u, v);
      feature.depth =
          with_depth ? p_C.z() + DepthNoise(sensor_.depth_noise).Sigma(p_C.z()) * noise(rng_) : 0.0;
      if (k > 0 && i % 10 == 0) feature.uv += 40.0 * Eigen::Vector2d(noise(rng_), noise(rng_));
      seen.push_back({static_cast<int>(i), feature});
    }
    return seen;
  }

  const RgbdSensor sensor_;
  std::mt19937 rng_{7};
  std::vector<Eigen::Vector3d> points_;
};

TEST_F(OdometryTutorial, FollowsTheCameraThroughWrongMatches) {
  Odometry odometry(sensor_);
  for (int k = 0; k < 60; ++k) {
    const std::optional<Pose> T_WC = odometry.AddImage(FromSeconds(k / 15.0), See(k));
    ASSERT_TRUE(T_WC) << k;
    const Pose error = T_WC->Inverse() * (At(0).Inverse() * At(k));
    // Odometry drifts: by 16 mm at most over 1.2 m, and 11 mm without wrong matches.
    EXPECT_LT(error.p().norm(), 0.02) << k;
    EXPECT_LT(error.Angle(), 0.005) << k;
  }
}

TEST_F(OdometryTutorial, TooFewPointsGiveNoPose) {
  Odometry odometry(sensor_);
  ASSERT_TRUE(odometry.AddImage(0, See(0)));
  std::vector<TrackedPoint> few = See(1);
  few.resize(4);
  EXPECT_FALSE(odometry.AddImage(FromSeconds(0.1), few));
  EXPECT_TRUE(odometry.AddImage(FromSeconds(0.2), See(2)));
}

TEST_F(OdometryTutorial, KnownPointsNeedNoDepth) {
  Odometry odometry(sensor_);
  ASSERT_TRUE(odometry.AddImage(0, See(0)));
  const std::optional<Pose> T_WC = odometry.AddImage(FromSeconds(0.1), See(1, false));
  ASSERT_TRUE(T_WC);
  EXPECT_LT((T_WC->Inverse() * (At(0).Inverse() * At(1))).p().norm(), 0.01);
}

}  // namespace
}  // namespace highwall
