#include "sensor/frame_timing_estimator.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "features/row_times.h"

namespace highwall {
namespace {

// [s] prior of an unknown camera: read-outs take up to an image's interval, some 33 ms; the two
// images are of the same interval.
const Eigen::Vector3d kPriorSigma(0.015, 0.015, 0.01);
const Eigen::Vector3d kLeastTiming(0.0, 0.0, -0.03), kMostTiming(0.05, 0.05, 0.03);  // [s]
// Number of standard deviations by which an estimate must differ from the known value to replace
// it.
constexpr double kConfidence = 2.0;
constexpr double kMemory = 5.0;  // [s] of the filter
// Frames share landmarks and thus errors: this number of frames counts as one.
constexpr double kCorrelatedReadings = 25.0;
constexpr double kMaxChi2 = 7.81;  // of three rows, 95 %
constexpr int kMinPoints = 30;
// Information of a pose below that of any image, which keeps unobservable directions out of the
// equations.
constexpr double kPoseFloor = 1e-3;

Eigen::Vector3d AsVector(const FrameTiming& timing) {
  return {timing.colour_readout, timing.depth_readout, timing.depth_delay};
}

FrameTiming AsTiming(const Eigen::Vector3d& vector, ReadoutDirection direction) {
  return {.colour_readout = vector[0],
          .depth_readout = vector[1],
          .depth_delay = vector[2],
          .direction = direction};
}

}  // namespace

FrameTimingEstimator::FrameTimingEstimator(const FrameTiming& known, const MeasurementModel& model,
                                           const DepthGrid& grid, const KeyframeRowTimes& keyframes)
    : model_(model),
      camera_(model.camera()),
      grid_(grid),
      known_(AsVector(known)),
      estimate_(known_),
      timing_(known),
      keyframes_(keyframes) {}

FrameTimingEstimator::Matrix FrameTimingEstimator::Covariance() const {
  Matrix information = information_;
  information.diagonal() += kPriorSigma.cwiseAbs2().cwiseInverse();
  return information.inverse();
}

FrameTimingEstimate FrameTimingEstimator::estimate() const {
  const Vector sigma = Covariance().diagonal().cwiseSqrt();
  return {.value = AsTiming(estimate_, timing_.direction),
          .sigma = AsTiming(sigma, timing_.direction)};
}

FrameTimingEstimator::Matrix FrameTimingEstimator::Shift(const PointFeature& feature,
                                                         const cv::Mat& depth_grid,
                                                         const Twist& motion) const {
  const Eigen::Vector3d p_C = camera_.Unproject(feature.uv, feature.depth);
  const double row_time = RowTime(feature.uv, camera_, timing_.direction);
  // The depth reading alone moves the point along its ray.
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
    const RowMotion* known = keyframes_.Find(observation.keyframe);
    if (known == nullptr) continue;
    const Matrix shift =
        keyframe->T_WC.q().toRotationMatrix() * Shift(feature, features.depth_grid, known->motion);
    landmark.shift += shift;
    Vector since = AsVector(timing_) - AsVector(known->timing);
    since[2] += keyframe->frame.depth_delay;  // included there, but no delay of the camera
    landmark.since += shift * since;
  }
  if (views > 0) {
    landmark.shift /= views;
    landmark.since /= views;
  }
  return landmark;
}

void FrameTimingEstimator::AddPoint(const PointFeature& feature, const MapPoint& point,
                                    const View& view, const Map& map, const Twist& motion,
                                    Equations* equations) const {
  const auto camera = RgbdProjection::At(view.T_WC.data());
  const Landmark landmark = ShiftOf(point, map);
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> dr_dpose;
  Eigen::Matrix3d dr_dp_W;
  if (!model_.projection().Evaluate<3>(camera, model_.Rows(feature), point.p_W + landmark.since, &r,
                                       &dr_dpose, &dr_dp_W) ||
      r.squaredNorm() > kMaxChi2) {
    return;
  }
  const Matrix seen = camera.R_BW.transpose() * Shift(feature, view.features.depth_grid, motion);
  Eigen::Matrix<double, 3, 9> J;
  J << dr_dpose, dr_dp_W * (landmark.shift - seen);
  equations->H += J.transpose() * J;
  equations->g += J.transpose() * r;
  ++equations->points;
}

void FrameTimingEstimator::Add(const View& view, const Map& map, const Twist& motion) {
  const double dt = ToSeconds(view.stamp - last_);
  if (dt <= 0.0) return;
  Equations equations;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const PointFeature& feature = view.features.points[i];
    const MapPoint* point = map.Find(view.points[i]);
    if (point == nullptr || !(feature.depth > 0.0)) continue;
    AddPoint(feature, *point, view, map, motion, &equations);
  }
  if (equations.points < kMinPoints) return;
  const Eigen::Matrix<double, 6, 6> pose =
      equations.H.topLeftCorner<6, 6>() + kPoseFloor * Eigen::Matrix<double, 6, 6>::Identity();
  const Eigen::Matrix<double, 6, 3> mixed = equations.H.topRightCorner<6, 3>();
  const Eigen::Matrix<double, 6, 3> eliminated = pose.ldlt().solve(mixed);
  const Matrix N = equations.H.bottomRightCorner<3, 3>() - mixed.transpose() * eliminated;
  const Vector g = equations.g.tail<3>() - eliminated.transpose() * equations.g.head<6>();
  information_ = std::exp(-dt / kMemory) * information_ + N / kCorrelatedReadings;
  last_ = view.stamp;
  const Matrix covariance = Covariance();
  // The residuals belong to the applied timing, not to the estimate.
  const Vector gradient = g + N * (estimate_ - AsVector(timing_));
  estimate_ = (estimate_ - covariance * gradient / kCorrelatedReadings)
                  .cwiseMax(kLeastTiming)
                  .cwiseMin(kMostTiming);
  const Eigen::Array3d uncertainty = kConfidence * covariance.diagonal().array().sqrt();
  timing_ = AsTiming(((estimate_ - known_).array().abs() > uncertainty).select(estimate_, known_),
                     timing_.direction);
}

}  // namespace highwall
