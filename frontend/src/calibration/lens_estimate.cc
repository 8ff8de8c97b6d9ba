#include "calibration/lens_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace highwall {
namespace {

constexpr int kLens = 6;  // fx fy cx cy [px], k1, offset of inverse depth [1/m]
constexpr int kDistortion = 4, kOffset = 5;
constexpr std::size_t kLeastKeyframes = 12, kLeastPoints = 100;
constexpr std::size_t kGroups = 8;  // of keyframes, for the scatter of the estimate
constexpr int kMostIterations = 8;
constexpr double kHuber = 2.5;
constexpr double kDistortionSigma = 0.5;    // prior of k1
constexpr double kOffsetSigma = 0.02;       // [1/m] prior of the offset of inverse depth
constexpr double kConverged = 1e-3;         // relative change of a focal length
constexpr double kLargestStep = 0.3;        // relative, of the focal lengths
constexpr double kMinDistance = 0.05;       // [m] of a point in front of the camera
constexpr double kLeastInformation = 1e-9;  // relative, of a point along its ray

using LensVector = Eigen::Matrix<double, kLens, 1>;
using LensMatrix = Eigen::Matrix<double, kLens, kLens>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

using View = LensViews::View;
using SeenPoint = LensViews::SeenPoint;

// Residual of a view and its derivatives, times the square root of its weight.
struct Linear {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> by_pose = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, kLens> by_lens = Eigen::Matrix<double, 3, kLens>::Zero();
};

// One Gauss-Newton problem: images, points and lens. The points are eliminated first, then the
// poses, so that what remains are the equations of the lens.
class LensProblem {
 public:
  LensProblem(LensViews views, const MeasurementModel& model)
      : c_(model.projection().fx() * model.projection().baseline()),
        poses_(std::move(views.T_CW)),
        held_(std::move(views.held)),
        points_(std::move(views.points)) {
    const PinholeCamera& camera = model.camera();
    known_ << camera.fx, camera.fy, camera.cx, camera.cy, 0.0, 0.0;
    lens_ = known_;
  }

  std::size_t points() const { return points_.size(); }

  // Returns false if the equations have no solution.
  bool Solve() {
    for (int i = 0; i < kMostIterations; ++i) {
      Linearize();
      if (!SolveLens()) return false;
      const LensVector step = Limited(-covariance_ * gradient_);
      Move(step);
      if (step.head<2>().cwiseAbs().maxCoeff() < kConverged * lens_[0]) break;
    }
    Linearize();
    return SolveLens() && (lens_.head<2>().array() > 0.0).all();
  }

  const LensVector& lens() const { return lens_; }

  // Growth of the squared residuals if one value returns to that of the model, relative.
  LensVector Growth() const {
    double squared = 0.0;
    for (const Linear& l : linear_) squared += l.r.squaredNorm();
    return (lens_ - known_).cwiseAbs2().cwiseQuotient(covariance_.diagonal()) /
           std::max(squared, 1e-12);
  }

  // Standard deviations by the scatter of the groups' contributions to the gradient.
  LensVector Sigma() const {
    const std::size_t groups = std::min(kGroups, poses_.size());
    std::vector<LensVector> parts(groups, LensVector::Zero());
    std::size_t next = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Matrix<double, 3, kLens> response = ResponseOf(i, next);
      for (const View& view : points_[i].views) {
        const Linear& l = linear_[next++];
        const Eigen::Matrix<double, 3, kLens> rest =
            l.by_lens - l.by_pose * response_.middleRows<6>(6 * Row(view.image)) -
            l.by_point * response;
        parts[view.image * groups / poses_.size()] += rest.transpose() * l.r;
      }
    }
    LensVector mean = LensVector::Zero();
    for (const LensVector& part : parts) mean += part / static_cast<double>(groups);
    LensMatrix scatter = LensMatrix::Zero();
    for (const LensVector& part : parts) scatter += (part - mean) * (part - mean).transpose();
    scatter *= static_cast<double>(groups) / static_cast<double>(groups - 1);
    return (covariance_ * scatter * covariance_).diagonal().cwiseMax(0.0).cwiseSqrt();
  }

 private:
  static Eigen::Index Row(std::size_t image) { return static_cast<Eigen::Index>(image); }

  Linear LinearOf(const SeenPoint& point, const View& view) const {
    Linear l;
    const Eigen::Vector3d p = poses_[view.image] * point.p_W;
    if (p.z() < kMinDistance) return l;
    const double iz = 1.0 / p.z(), x = p.x() * iz, y = p.y() * iz;
    const Eigen::Matrix3d& A = view.rows.A;
    const double squared = x * x + y * y, k = lens_[kDistortion], g = 1.0 + k * squared;
    l.r = A * Eigen::Vector3d(lens_[0] * x * g + lens_[2], lens_[1] * y * g + lens_[3],
                              c_ * (iz + lens_[kOffset])) +
          view.rows.b;
    Eigen::Matrix2d by_xy;  // of the pixel
    by_xy << lens_[0] * (g + 2.0 * k * x * x), lens_[0] * 2.0 * k * x * y,
        lens_[1] * 2.0 * k * x * y, lens_[1] * (g + 2.0 * k * y * y);
    Eigen::Matrix3d by_p;
    by_p << by_xy * iz, -by_xy * Eigen::Vector2d(x, y) * iz, 0.0, 0.0, -c_ * iz * iz;
    by_p = (A * by_p).eval();
    l.by_pose.leftCols<3>() = by_p;  // p <- p + d + theta x p
    for (int i = 0; i < 3; ++i) {
      l.by_pose.block<1, 3>(i, 3) = -by_p.row(i).cross(p.transpose());
    }
    l.by_point = by_p * poses_[view.image].R();
    l.by_lens << x * g * A.col(0), y * g * A.col(1), A.col(0), A.col(1),
        squared * (lens_[0] * x * A.col(0) + lens_[1] * y * A.col(1)), c_ * A.col(2);
    const double norm = l.r.norm();
    const double weight = norm > kHuber ? std::sqrt(kHuber / norm) : 1.0;
    l.r *= weight;
    l.by_pose *= weight;
    l.by_point *= weight;
    l.by_lens *= weight;
    return l;
  }

  // Fills the equations of poses and lens without the points.
  void Linearize() {
    const Eigen::Index size = 6 * Row(poses_.size());
    poses_poses_ = Eigen::MatrixXd::Zero(size, size);
    poses_lens_ = Eigen::MatrixXd::Zero(size, kLens);
    poses_gradient_ = Eigen::VectorXd::Zero(size);
    lens_lens_ = LensMatrix::Zero();
    lens_gradient_ = LensVector::Zero();
    AddPrior(kDistortion, kDistortionSigma);
    AddPrior(kOffset, kOffsetSigma);
    linear_.clear();
    inverses_.clear();
    for (const SeenPoint& point : points_) AddPoint(point);
    for (const std::size_t image : held_) {
      poses_poses_.diagonal().segment<6>(6 * Row(image)).array() += 1e12;
    }
  }

  // Of a value about zero.
  void AddPrior(int value, double sigma) {
    lens_lens_(value, value) = 1.0 / (sigma * sigma);
    lens_gradient_[value] = lens_[value] / (sigma * sigma);
  }

  void AddPoint(const SeenPoint& point) {
    const std::size_t first = linear_.size();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, kLens> point_lens = Eigen::Matrix<double, 3, kLens>::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const View& view : point.views) {
      const Linear& l = linear_.emplace_back(LinearOf(point, view));
      information += l.by_point.transpose() * l.by_point;
      point_lens += l.by_point.transpose() * l.by_lens;
      gradient += l.by_point.transpose() * l.r;
      const Eigen::Index row = 6 * Row(view.image);
      poses_poses_.block<6, 6>(row, row) += l.by_pose.transpose() * l.by_pose;
      poses_lens_.middleRows<6>(row) += l.by_pose.transpose() * l.by_lens;
      poses_gradient_.segment<6>(row) += l.by_pose.transpose() * l.r;
      lens_lens_ += l.by_lens.transpose() * l.by_lens;
      lens_gradient_ += l.by_lens.transpose() * l.r;
    }
    information.diagonal().array() += kLeastInformation * information.trace() + 1e-12;
    const Eigen::Matrix3d inverse = information.inverse();
    inverses_.push_back(inverse);
    std::vector<Eigen::Matrix<double, 6, 3>> pose_point;
    for (std::size_t i = 0; i < point.views.size(); ++i) {
      const Linear& l = linear_[first + i];
      pose_point.push_back(l.by_pose.transpose() * l.by_point);
    }
    for (std::size_t i = 0; i < point.views.size(); ++i) {
      const Eigen::Matrix<double, 6, 3> through = pose_point[i] * inverse;
      const Eigen::Index row = 6 * Row(point.views[i].image);
      for (std::size_t j = 0; j < point.views.size(); ++j) {
        poses_poses_.block<6, 6>(row, 6 * Row(point.views[j].image)) -=
            through * pose_point[j].transpose();
      }
      poses_lens_.middleRows<6>(row) -= through * point_lens;
      poses_gradient_.segment<6>(row) -= through * gradient;
    }
    lens_lens_ -= point_lens.transpose() * inverse * point_lens;
    lens_gradient_ -= point_lens.transpose() * inverse * gradient;
  }

  // Eliminates the poses.
  bool SolveLens() {
    poses_solver_.compute(poses_poses_);
    if (poses_solver_.info() != Eigen::Success) return false;
    response_ = poses_solver_.solve(poses_lens_);
    const LensMatrix rest = lens_lens_ - poses_lens_.transpose() * response_;
    const Eigen::LDLT<LensMatrix> solver(rest);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
    covariance_ = solver.solve(LensMatrix::Identity());
    gradient_ = lens_gradient_ - response_.transpose() * poses_gradient_;
    return covariance_.allFinite() && gradient_.allFinite();
  }

  // How a point follows the lens. first: of its views in linear_.
  Eigen::Matrix<double, 3, kLens> ResponseOf(std::size_t point, std::size_t first) const {
    Eigen::Matrix<double, 3, kLens> sum = Eigen::Matrix<double, 3, kLens>::Zero();
    for (std::size_t i = 0; i < points_[point].views.size(); ++i) {
      const Linear& l = linear_[first + i];
      const Eigen::Index row = 6 * Row(points_[point].views[i].image);
      sum += l.by_point.transpose() * (l.by_lens - l.by_pose * response_.middleRows<6>(row));
    }
    return inverses_[point] * sum;
  }

  LensVector Limited(const LensVector& step) const {
    const double relative = std::max(std::abs(step[0] / lens_[0]), std::abs(step[1] / lens_[1]));
    return relative > kLargestStep ? LensVector(step * (kLargestStep / relative)) : step;
  }

  void Move(const LensVector& step) {
    const Eigen::VectorXd poses_step = -poses_solver_.solve(poses_gradient_) - response_ * step;
    std::size_t next = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const View& view : points_[i].views) {
        const Linear& l = linear_[next++];
        sum += l.by_point.transpose() *
               (l.r + l.by_lens * step + l.by_pose * poses_step.segment<6>(6 * Row(view.image)));
      }
      points_[i].p_W -= inverses_[i] * sum;
    }
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Vector6 d = poses_step.segment<6>(6 * Row(k));
      poses_[k] = Pose::FromTangent(d.head<3>(), d.tail<3>()) * poses_[k];
    }
    lens_ += step;
  }

  const double c_;
  LensVector known_, lens_;
  std::vector<Pose> poses_;  // T_CW
  std::vector<std::size_t> held_;
  std::vector<SeenPoint> points_;
  std::vector<Linear> linear_;             // of all views, by points
  std::vector<Eigen::Matrix3d> inverses_;  // of the information of each point
  Eigen::MatrixXd poses_poses_, poses_lens_, response_;
  Eigen::VectorXd poses_gradient_;
  LensMatrix lens_lens_, covariance_;
  LensVector lens_gradient_, gradient_;
  Eigen::LDLT<Eigen::MatrixXd> poses_solver_;
};

LensViews ViewsOf(const Map& map, const MeasurementModel& model,
                  std::span<const KeyFrameId> keyframes) {
  LensViews views;
  views.held = {0};
  std::unordered_map<KeyFrameId, std::size_t> index;
  for (const KeyFrameId id : keyframes) {
    index.emplace(id, views.T_CW.size());
    views.T_CW.push_back(map.keyframe(id)->T_WC.Inverse());
  }
  for (const PointId id : map.ids<MapPoint>()) {
    const MapPoint& point = *map.Find(id);
    SeenPoint seen{point.p_W, {}};
    bool has_depth = false;
    for (const Observation& o : point.observations) {
      const auto it = index.find(o.keyframe);
      if (it == index.end()) continue;
      const PointFeature& feature =
          map.keyframe(o.keyframe)->frame.features->points[static_cast<std::size_t>(o.index)];
      seen.views.push_back({it->second, model.Rows(feature)});
      has_depth |= feature.depth > 0.0;
    }
    if (has_depth && seen.views.size() > 1) views.points.push_back(std::move(seen));
  }
  return views;
}

}  // namespace

std::optional<LensEstimate> EstimateLens(LensViews views, const MeasurementModel& model) {
  const std::size_t images = views.T_CW.size();
  LensProblem problem(std::move(views), model);
  if (problem.points() < kLeastPoints || !problem.Solve()) return std::nullopt;
  LensEstimate estimate{.intrinsics = problem.lens().head<4>(),
                        .sigma = problem.Sigma().head<4>(),
                        .growth = problem.Growth().head<4>(),
                        .distortion = {.k1 = problem.lens()[kDistortion],
                                       .sigma = problem.Sigma()[kDistortion],
                                       .growth = problem.Growth()[kDistortion]},
                        .keyframes = static_cast<int>(images),
                        .points = static_cast<int>(problem.points())};
  const LensEstimate::Distortion& distortion = estimate.distortion;
  if (!estimate.intrinsics.allFinite() || !estimate.sigma.allFinite() ||
      !estimate.growth.allFinite() ||
      !Eigen::Vector3d(distortion.k1, distortion.sigma, distortion.growth).allFinite()) {
    return std::nullopt;
  }
  return estimate;
}

std::optional<LensEstimate> EstimateLens(const Map& map, const MeasurementModel& model,
                                         std::span<const KeyFrameId> keyframes) {
  if (keyframes.size() < kLeastKeyframes) return std::nullopt;
  return EstimateLens(ViewsOf(map, model, keyframes), model);
}

}  // namespace highwall
