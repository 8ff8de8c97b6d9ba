#pragma once

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
