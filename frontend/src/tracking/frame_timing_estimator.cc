#include "tracking/frame_timing_estimator.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "features/row_times.h"

namespace highwall {
namespace {

// [s] of what is not known of a camera: read-outs take up to an image's interval, some 33 ms; the
// two images are of the same interval.
const Eigen::Vector3d kPriorSigma(0.015, 0.015, 0.01);
constexpr double kLongestReadout = 0.05, kLongestDelay = 0.03;  // [s]
constexpr double kMemory = 5.0;                                 // [s] of the filter
// Frames share landmarks, and with them errors: so many count as one.
constexpr double kAlike = 25.0;
constexpr double kMaxChi2 = 7.81;  // of three rows, 95 %
constexpr int kMinPoints = 30;
// Less of a pose than any image tells, which keeps what it leaves open out of the equations.
constexpr double kPoseFloor = 1e-3;

Eigen::Vector3d AsVector(const FrameTiming& timing) {
  return {timing.colour_readout, timing.depth_readout, timing.depth_delay};
}

}  // namespace

FrameTimingEstimator::FrameTimingEstimator(const FrameTiming& known, const MeasurementModel& model,
                                           const DepthGrid& grid)
    : model_(model), camera_(model.camera()), grid_(grid), timing_(known) {}

FrameTimingEstimator::Matrix FrameTimingEstimator::Covariance() const {
  Matrix information = information_;
  information.diagonal() += kPriorSigma.cwiseAbs2().cwiseInverse();
  return information.inverse();
}

FrameTimingEstimate FrameTimingEstimator::estimate() const {
  const Vector sigma = Covariance().diagonal().cwiseSqrt();
  return {
      .value = timing_,
      .sigma = {.colour_readout = sigma[0], .depth_readout = sigma[1], .depth_delay = sigma[2]}};
}

void FrameTimingEstimator::Remember(const KeyFrame& keyframe, const Twist& motion) {
  keyframes_[keyframe.id] = {motion, AsVector(timing_)};
}

FrameTimingEstimator::Matrix FrameTimingEstimator::Shift(const PointFeature& feature,
                                                         const cv::Mat& depth_grid,
                                                         const Twist& motion) const {
  const Eigen::Vector3d p_C = camera_.Unproject(feature.uv, feature.depth);
  const double row_time = RowTime(feature.uv.y(), camera_.height);
  // The reading alone moves the point along its ray.
  const double rate = DepthRate(depth_grid, grid_, p_C, motion).value_or(0.0);
  const Eigen::Vector3d reading = -rate / p_C.z() * p_C;
  Matrix shift;
  shift << row_time * (-motion.Flow(p_C) - reading), row_time * reading, reading;
  return shift;
}

FrameTimingEstimator::Landmark FrameTimingEstimator::ShiftOf(const MapPoint& point,
                                                             const Map& map) const {
  Landmark landmark;
  int views = 0;
  for (const Observation& observation : point.observations) {
    const KeyFrame* keyframe = map.keyframe(observation.keyframe);
    if (keyframe == nullptr) continue;
    const FrameFeatures& features = *keyframe->frame.features;
    const PointFeature& feature = features.points[static_cast<std::size_t>(observation.index)];
    if (!(feature.depth > 0.0)) continue;
    ++views;
    const auto known = keyframes_.find(observation.keyframe);
    if (known == keyframes_.end()) continue;
    const auto& [motion, timing] = known->second;
    const Matrix shift =
        keyframe->T_WC.q().toRotationMatrix() * Shift(feature, features.depth_grid, motion);
    landmark.shift += shift;
    landmark.since += shift * (AsVector(timing_) - timing);
  }
  if (views > 0) {
    landmark.shift /= views;
    landmark.since /= views;
  }
  return landmark;
}

void FrameTimingEstimator::AddPoint(const PointFeature& feature, const MapPoint& point,
                                    const TrackedFrame& tracked, const Map& map,
                                    const Twist& motion, Equations* equations) const {
  const auto view = RgbdProjection::At(tracked.T_WC.data());
  const Landmark landmark = ShiftOf(point, map);
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> dr_dpose;
  Eigen::Matrix3d dr_dp_W;
  if (!model_.projection().Evaluate<3>(view, model_.Rows(feature), point.p_W + landmark.since, &r,
                                       &dr_dpose, &dr_dp_W) ||
      r.squaredNorm() > kMaxChi2) {
    return;
  }
  const Matrix seen =
      view.R_BW.transpose() * Shift(feature, tracked.frame.features->depth_grid, motion);
  Eigen::Matrix<double, 3, 9> J;
  J << dr_dpose, dr_dp_W * (landmark.shift - seen);
  equations->H += J.transpose() * J;
  equations->g += J.transpose() * r;
  ++equations->points;
}

void FrameTimingEstimator::Add(const TrackedFrame& tracked, const Map& map, const Twist& motion) {
  const double dt = ToSeconds(tracked.frame.stamp - last_);
  if (dt <= 0.0) return;
  Equations equations;
  const FrameFeatures& features = *tracked.frame.features;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    const MapPoint* point = map.point(tracked.points[i]);
    if (point == nullptr || !(features.points[i].depth > 0.0)) continue;
    AddPoint(features.points[i], *point, tracked, map, motion, &equations);
  }
  if (equations.points < kMinPoints) return;
  const Eigen::Matrix<double, 6, 6> pose =
      equations.H.topLeftCorner<6, 6>() + kPoseFloor * Eigen::Matrix<double, 6, 6>::Identity();
  const Eigen::Matrix<double, 6, 3> mixed = equations.H.topRightCorner<6, 3>();
  const Eigen::Matrix<double, 6, 3> eliminated = pose.ldlt().solve(mixed);
  const Matrix N = equations.H.bottomRightCorner<3, 3>() - mixed.transpose() * eliminated;
  const Vector g = equations.g.tail<3>() - eliminated.transpose() * equations.g.head<6>();
  information_ = std::exp(-dt / kMemory) * information_ + N / kAlike;
  last_ = tracked.frame.stamp;
  const Vector step = -(Covariance() * g) / kAlike;
  timing_.colour_readout = std::clamp(timing_.colour_readout + step[0], 0.0, kLongestReadout);
  timing_.depth_readout = std::clamp(timing_.depth_readout + step[1], 0.0, kLongestReadout);
  timing_.depth_delay = std::clamp(timing_.depth_delay + step[2], -kLongestDelay, kLongestDelay);
}

}  // namespace highwall
