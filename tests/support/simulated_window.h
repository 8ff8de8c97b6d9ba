#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/so3.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/internal/se3.h>

// A camera that moves past points and lines, for tests and benchmarks of the smoother.
namespace highwall {

struct SimulatedWindowOptions {
  int new_points = 20;                        // first seen from each keyframe
  int new_lines = 10;                         // the same
  int track_length = 10;                      // keyframes from which a landmark is seen
  double pixel_sigma = 1.0;                   // [px]
  double disparity_sigma = 0.5;               // [px]
  double odometry_sigma = 0.02;               // [m, rad]; 0: no odometry
  double prior_sigma = 0.01;                  // [m, rad] of the first pose
  std::shared_ptr<ceres::LossFunction> loss;  // of the observations
};

// Every measurement of a factor is drawn from the distribution given by its weight.
class SimulatedWindow {
 public:
  SimulatedWindow(const SimulatedWindowOptions& options, unsigned seed)
      : options_(options), rng_(seed), projection_(PinholeCamera(), Pose()) {}

  // Moves back and forth near the origin, about 0.1 m per keyframe.
  static Pose Truth(int k) {
    const double t = 0.1 * k;
    return Pose::FromTangent({5.0 * std::sin(0.2 * t), 0.3 * std::sin(t), 0.2 * std::cos(1.3 * t)},
                             {0.1 * std::sin(0.7 * t), 0.15 * std::sin(t), 0.1 * std::cos(t)});
  }

  // Adds the next keyframe, its observations and the landmarks that begin with it. The caller then
  // calls smoother->Update().
  Variable<Pose> AddKeyframe(SlidingWindowSmoother* smoother) {
    const int k = count_++;
    const Pose T = Truth(k);
    const Pose guess = Guess(k, *smoother);
    const Variable<Pose> pose = smoother->AddState(Stamp{k}, guess);
    if (k == 0) {
      smoother->AddFactor(std::make_unique<PosePrior>(guess, Weight(options_.prior_sigma)), pose);
    } else if (options_.odometry_sigma > 0.0) {
      smoother->AddFactor(
          std::make_unique<RelativePose>(odometry_, Weight(options_.odometry_sigma)), last_, pose);
    }
    for (int i = 0; i < options_.new_points; ++i) AddPoint(guess, smoother);
    for (int i = 0; i < options_.new_lines; ++i) AddLine(guess, smoother);
    std::erase_if(points_, [&](const auto& x) {
      return x.last_keyframe < k || !smoother->Contains(x.variable);
    });
    std::erase_if(lines_, [&](const auto& x) {
      return x.last_keyframe < k || !smoother->Contains(x.variable);
    });
    for (const auto& point : points_) See(T, pose, point, smoother);
    for (const auto& line : lines_) See(T, pose, line, smoother);
    last_ = pose;
    return pose;
  }

  int count() const { return count_; }

 private:
  template <class T, class Truth>
  struct Track {
    Variable<T> variable;
    Truth truth;
    int last_keyframe;
  };
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  double Gauss(double sigma) { return std::normal_distribution<double>(0.0, sigma)(rng_); }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Vector6 Noise(double sigma) {
    Vector6 noise;
    for (int i = 0; i < 6; ++i) noise[i] = Gauss(sigma);
    return noise;
  }
  static Matrix6 Weight(double sigma) { return Matrix6::Identity() / sigma; }

  // Returns the initial pose: the first one from the prior, later ones from odometry.
  Pose Guess(int k, const SlidingWindowSmoother& smoother) {
    if (k == 0) {
      // T = T_0 Plus noise, so that T_0 = guess.
      const Vector6 noise = Noise(options_.prior_sigma);
      const Pose T = Truth(0);
      return Pose(T.q() * so3::Exp(-noise.tail<3>()), T.p() - noise.head<3>());
    }
    const double sigma = options_.odometry_sigma > 0.0 ? options_.odometry_sigma : 0.02;
    odometry_ = Truth(k - 1).Inverse() * Truth(k) * se3::Exp(Noise(sigma));
    return smoother.Value(last_) * odometry_;
  }

  Eigen::Vector3d PointInView() {
    const double z = Uniform(2.5, 6.0);
    const Pose middle = Truth(count_ - 1 + options_.track_length / 2);
    return middle * Eigen::Vector3d(Uniform(-0.4, 0.4) * z, Uniform(-0.35, 0.35) * z, z);
  }
  Eigen::Vector3d Observe(const Pose& T_WB, const Eigen::Vector3d& p_W) const {
    return projection_.Project(T_WB.Inverse() * p_W);
  }
  Eigen::Vector3d Disturb(const Eigen::Vector3d& y) {
    return y + Eigen::Vector3d(Gauss(options_.pixel_sigma), Gauss(options_.pixel_sigma),
                               Gauss(options_.disparity_sigma));
  }
  Eigen::Vector3d Unproject(const Pose& T_WB, const Eigen::Vector3d& y) const {
    const double z = projection_.fx() * projection_.baseline() / std::max(1.0, y.z());
    return T_WB * Eigen::Vector3d((y.x() - projection_.cx()) / projection_.fx() * z,
                                  (y.y() - projection_.cy()) / projection_.fy() * z, z);
  }

  void AddPoint(const Pose& guess, SlidingWindowSmoother* smoother) {
    const Eigen::Vector3d p = PointInView();
    const Point start = Unproject(guess, Disturb(Observe(Truth(count_ - 1), p)));
    points_.push_back({smoother->AddLandmark(start), p, count_ - 2 + options_.track_length});
  }
  void AddLine(const Pose& guess, SlidingWindowSmoother* smoother) {
    const Eigen::Vector3d p = PointInView();
    // 1 m long and not along the line of sight.
    const Pose T = Truth(count_ - 1);
    const double angle = Uniform(-M_PI, M_PI);
    const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), Uniform(-0.3, 0.3));
    const Segment3 segment(p, p + T.R() * direction);
    const OrthonormalLine start(
        PluckerLine::FromPoints(Unproject(guess, Disturb(Observe(T, segment.p()))),
                                Unproject(guess, Disturb(Observe(T, segment.q())))));
    lines_.push_back({smoother->AddLandmark(start), segment, count_ - 2 + options_.track_length});
  }
  void See(const Pose& T, const Variable<Pose>& pose, const Track<Point, Eigen::Vector3d>& point,
           SlidingWindowSmoother* smoother) {
    const Eigen::Vector3d z = Disturb(Observe(T, point.truth));
    const Eigen::Vector3d weights(1.0 / options_.pixel_sigma, 1.0 / options_.pixel_sigma,
                                  1.0 / options_.disparity_sigma);
    smoother->AddFactor(std::make_unique<PointReprojectionRgbd>(
                            z, Eigen::Matrix3d(weights.asDiagonal()), projection_),
                        options_.loss, pose, point.variable);
  }
  void See(const Pose& T, const Variable<Pose>& pose, const Track<OrthonormalLine, Segment3>& line,
           SlidingWindowSmoother* smoother) {
    const RgbdSegment observed{Disturb(Observe(T, line.truth.p())),
                               Disturb(Observe(T, line.truth.q()))};
    const SegmentNoise noise{options_.pixel_sigma, options_.disparity_sigma,
                             options_.disparity_sigma};
    smoother->AddFactor(std::make_unique<OrthonormalLineReprojectionRgbd>(
                            observed, noise, Weighting::kCovariance, projection_),
                        options_.loss, pose, line.variable);
  }

  SimulatedWindowOptions options_;
  std::mt19937 rng_;
  RgbdProjection projection_;
  int count_ = 0;
  Variable<Pose> last_;
  Pose odometry_;
  std::vector<Track<Point, Eigen::Vector3d>> points_;
  std::vector<Track<OrthonormalLine, Segment3>> lines_;
};

}  // namespace highwall
