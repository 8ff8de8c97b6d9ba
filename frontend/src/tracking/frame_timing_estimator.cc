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
// What the map has taken on of an error is not seen: about half.
constexpr double kOverRelaxation = 2.0;
constexpr double kMaxChi2 = 7.81;  // of three rows, 95 %
constexpr int kMinPoints = 30;
// Less of a pose than any image tells, which keeps what it leaves open out of the equations.
constexpr double kPoseFloor = 1e-3;

}  // namespace

FrameTimingEstimator::FrameTimingEstimator(const FrameTiming& known, const MeasurementModel& model,
                                           const DepthGrid& grid)
    : model_(model), grid_(grid), timing_(known) {}

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

void FrameTimingEstimator::AddPoint(const PointFeature& feature, const Eigen::Vector3d& p_W,
                                    const TrackedFrame& tracked, const Twist& motion,
                                    Equations* equations) const {
  const RgbdProjection& camera = model_.projection();
  const auto view = RgbdProjection::At(tracked.T_WC.data());
  const ProjectionRows<3> rows = model_.Rows(feature);
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> dr_dpose;
  Eigen::Matrix3d dr_dp_W;
  if (!camera.Evaluate<3>(view, rows, p_W, &r, &dr_dpose, &dr_dp_W)) return;
  if (r.squaredNorm() > kMaxChi2) return;
  const Eigen::Vector3d p_C = view.R_BW * (p_W - view.p_WB);
  const Eigen::Vector3d flow = motion.Flow(p_C);
  const double row_time = RowTime(feature.uv.y(), model_.camera().height);
  // By how much the rows change when the pixel, or its depth alone, is a second later.
  const Eigen::Vector3d later = dr_dp_W * (view.R_BW.transpose() * flow);
  Eigen::Vector3d depth_later = Eigen::Vector3d::Zero();
  if (const auto rate = DepthRate(tracked.frame.features->depth_grid, grid_, p_C, motion)) {
    const double per_metre = -camera.fx() * camera.baseline() / (feature.depth * feature.depth);
    depth_later = rows.A.col(2) * (per_metre * *rate);
  }
  Eigen::Matrix<double, 3, 9> J;
  J << dr_dpose, row_time * (later - depth_later), row_time * depth_later, depth_later;
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
    AddPoint(features.points[i], point->p_W, tracked, motion, &equations);
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
  const Vector step = -kOverRelaxation / kAlike * (Covariance() * g);
  timing_.colour_readout = std::clamp(timing_.colour_readout + step[0], 0.0, kLongestReadout);
  timing_.depth_readout = std::clamp(timing_.depth_readout + step[1], 0.0, kLongestReadout);
  timing_.depth_delay = std::clamp(timing_.depth_delay + step[2], -kLongestDelay, kLongestDelay);
}

}  // namespace highwall
