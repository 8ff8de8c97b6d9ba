#include "pose/direct_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <ceres/tiny_solver.h>
#include <Eigen/Cholesky>
#include <opencv2/imgproc.hpp>

#include <highwall/core/so3.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/internal/median.h>

#include "pose/degeneracy.h"
#include "pose/surface_matcher.h"

namespace highwall {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kHuber = 1.345;  // [sigma] 95 % efficient for Gaussian noise
// [grey levels] Effects of light beyond gain and offset.
constexpr double kMinGreySigma = 2.0;

constexpr double kMaxSigma = 0.05;   // [m] a pose whose worst direction exceeds this is rejected
constexpr double kMinOverlap = 0.3;  // share of the frame's depth that the reference must see
// Number of readings with common noise: the patches of 9 x 9 cells, at every second cell, overlap
// twenty-fold. Grey levels are independent, but where one view hides much of the other, the
// outlines of what both see have common errors.
constexpr double kSharedNoise = 20.0;
constexpr double kMostSeen = 2.0 / 3.0;  // overlap of views in which little is hidden

// Stage of the coarse-to-fine iteration: blur of the grey grids and gate of the surfaces, by the
// remaining pose error.
struct Stage {
  double blur;       // [cells] standard deviation; 0: none
  int spacing;       // [cells] of the readings, below the blur: finer ones repeat each other
  double gate;       // [m]
  double converged;  // [m, rad] norm of the last step
};
// Every third cell was chosen with one recording; every fourth loses frames of it.
constexpr std::array<Stage, 3> kStages{
    {{4.0, 3, 0.2, 1e-3}, {2.0, 1, 0.08, 3e-4}, {0.0, 1, 0.03, 1e-4}}};
constexpr int kSteps = 15;         // per stage, each with new associations
constexpr int kIterations = 2;     // per step
constexpr double kSettled = 1e-3;  // [m, rad] maximum norm of the last step, else no convergence

// The grey levels of an image and their gradient, at fractional cells.
class GreyImage {
 public:
  GreyImage(const cv::Mat& cells, double blur) {
    cells.convertTo(grey_, CV_32F);
    if (blur > 0.0) cv::GaussianBlur(grey_, grey_, {}, blur);
  }

  // Bilinear; false at the border and beyond. gradient: along u and v [grey levels / cell].
  bool At(const Eigen::Vector2d& uv, double* value, Eigen::Vector2d* gradient) const {
    const double u = std::floor(uv.x()), v = std::floor(uv.y());
    if (!(u >= 0.0 && v >= 0.0 && u + 1.0 < grey_.cols && v + 1.0 < grey_.rows)) return false;
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const double a = uv.x() - u, b = uv.y() - v;
    const auto at = [&](int i, int j) {
      return static_cast<double>(grey_.at<float>(y + j, x + i));
    };
    const double top = at(1, 0) - at(0, 0), bottom = at(1, 1) - at(0, 1);
    *value = (1.0 - b) * (at(0, 0) + a * top) + b * (at(0, 1) + a * bottom);
    *gradient = {(1.0 - b) * top + b * bottom,
                 (1.0 - a) * (at(0, 1) - at(0, 0)) + a * (at(1, 1) - at(1, 0))};
    return true;
  }

  double Of(const cv::Point& cell) const { return static_cast<double>(grey_.at<float>(cell)); }

 private:
  cv::Mat grey_;
};

// A reading of the frame with its grey level converted to that of the reference.
struct GreyPoint {
  Eigen::Vector3d p_C;
  double grey = 0.0;
  double weight = 1.0;  // [1 / grey level]
};

// Residuals of planes and grey levels as a function of the step away from T_RC. The functor of
// ceres::TinySolver.
class AlignmentProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  AlignmentProblem(const DepthGrid& grid, const GreyImage& grey, const Pose& T_RC,
                   std::vector<PointToPlaneRow> planes, std::vector<GreyPoint> points)
      : camera_(grid.camera()),
        grey_(grey),
        T_RC_(T_RC),
        planes_(std::move(planes)),
        points_(std::move(points)) {}

  int NumResiduals() const { return static_cast<int>(planes_.size() + points_.size()); }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Vector6 step = Eigen::Map<const Vector6>(x);
    if (!step.allFinite()) {
      std::fill_n(residuals, NumResiduals(), std::numeric_limits<double>::infinity());
      return false;
    }
    const Pose T = T_RC_.Plus(step);
    const Eigen::Matrix3d R = T.R();
    const Eigen::Matrix3d step_jacobian = so3::RightJacobian(step.tail<3>());
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6>> J(jacobian, NumResiduals(), 6);
    Eigen::Index row = 0;
    Eigen::Matrix<double, 1, 6> J_row;
    auto* const wanted = jacobian != nullptr ? &J_row : nullptr;
    const auto put = [&](double r) {
      residuals[row] = r;
      if (wanted != nullptr) {
        J.row(row).head<3>() = J_row.head<3>();
        J.row(row).tail<3>() = J_row.tail<3>() * step_jacobian;
      }
      ++row;
    };
    for (const PointToPlaneRow& plane : planes_) put(plane.Evaluate(R, T.p(), wanted));
    for (const GreyPoint& point : points_) put(Grey(R, T.p(), point, wanted));
    return true;
  }

 private:
  // Points outside the reference's view cost as much as outliers. J: may be null.
  double Grey(const Eigen::Matrix3d& R, const Eigen::Vector3d& p, const GreyPoint& point,
              Eigen::Matrix<double, 1, 6>* J) const {
    const Eigen::Vector3d p_R = R * point.p_C + p;
    double value = 0.0;
    Eigen::Vector2d gradient;
    if (p_R.z() <= 0.0 || !grey_.At(camera_.Project(p_R), &value, &gradient)) {
      if (J != nullptr) J->setZero();
      return kHuber;
    }
    if (J == nullptr) return point.weight * (value - point.grey);
    const double iz = 1.0 / p_R.z();
    const Eigen::Vector2d g =
        point.weight * iz * gradient.cwiseProduct(Eigen::Vector2d(camera_.fx, camera_.fy));
    const Eigen::Vector3d along(g.x(), g.y(), -iz * (g.x() * p_R.x() + g.y() * p_R.y()));
    J->head<3>() = along.transpose();
    J->tail<3>() = point.p_C.cross(R.transpose() * along).transpose();
    return point.weight * (value - point.grey);
  }

  const PinholeCamera& camera_;
  const GreyImage& grey_;
  Pose T_RC_;
  std::vector<PointToPlaneRow> planes_;
  std::vector<GreyPoint> points_;
};

double HuberFactor(double r) {
  return std::abs(r) <= kHuber ? 1.0 : std::sqrt(kHuber / std::abs(r));
}

// Grey levels of the frame and of the reference at common points.
struct GreyPairs {
  std::vector<Eigen::Vector3d> p_C;
  std::vector<double> own, other;
  int readings = 0;  // of the frame, inside the reference's view or not

  // Correlation of the two, and the gain and offset that convert `own` to `other`.
  struct Likeness {
    double correlation = 0.0, gain = 1.0, offset = 0.0;
  };
  Likeness Compare() const {
    const auto n = static_cast<double>(own.size());
    double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    for (std::size_t i = 0; i < own.size(); ++i) {
      a += own[i], b += other[i];
      aa += own[i] * own[i], bb += other[i] * other[i], ab += own[i] * other[i];
    }
    const double var_a = aa / n - a * a / (n * n), var_b = bb / n - b * b / (n * n);
    const double covariance = ab / n - a * b / (n * n);
    if (!(var_a > 0.0) || !(var_b > 0.0)) return {0.0, 1.0, (b - a) / n};
    const double gain = std::sqrt(var_b / var_a);  // symmetric: both are noisy
    return {covariance / std::sqrt(var_a * var_b), gain, (b - gain * a) / n};
  }
};

// State of one alignment.
class Alignment {
 public:
  Alignment(const DepthGrid& grid, const DepthNoise& noise, const FrameFeatures& reference,
            const cv::Mat& standing, const FrameFeatures& features, const Pose& T_RC)
      : grid_(grid),
        noise_(noise),
        reference_(reference),
        standing_(standing),
        features_(features),
        T_RC_(T_RC) {}

  // Returns false if there are too few constraints, or it does not converge.
  bool Refine(const std::vector<SurfacePatch>& patches, const Stage& stage) {
    const GreyImage reference(reference_.gray_grid, stage.blur);
    const GreyImage own(features_.gray_grid, stage.blur);
    for (int step = 0; step < kSteps; ++step) {
      const GreyPairs pairs = Pair(reference, own, stage);
      if (static_cast<int>(pairs.own.size()) * stage.spacing * stage.spacing < kMinPairs) {
        return false;
      }
      std::vector<PointToPlaneRow> planes =
          MatchPatches(patches, features_.depth_grid, {}, T_RC_, grid_, noise_, stage.gate);
      planes_ = static_cast<int>(planes.size());
      const AlignmentProblem problem(grid_, reference, T_RC_, Weighed(std::move(planes)),
                                     Weighed(pairs));
      ceres::TinySolver<AlignmentProblem> solver;
      solver.options.max_num_iterations = kIterations;
      Vector6 x = Vector6::Zero();
      solver.Solve(problem, &x);
      if (!x.allFinite()) return false;
      T_RC_ = T_RC_.Plus(x);
      last_step_ = x.norm();
      if (last_step_ < stage.converged || step + 1 == kSteps) {
        Measure(problem, x);
        break;
      }
    }
    return last_step_ <= kSettled;
  }

  // Compares the grey levels at the pose that was found, without blur.
  void Compare() {
    const GreyImage reference(reference_.gray_grid, 0.0), own(features_.gray_grid, 0.0);
    const GreyPairs pairs = Pair(reference, own, kStages.back());
    likeness_ = pairs.Compare();
    overlap_ = pairs.readings > 0 ? static_cast<double>(pairs.own.size()) / pairs.readings : 0.0;
  }

  const Pose& T_RC() const { return T_RC_; }
  double plane_error() const { return plane_error_; }
  double grey_error() const { return grey_error_; }
  int planes() const { return planes_; }
  double overlap() const { return overlap_; }
  double correlation() const { return likeness_.correlation; }
  // Of all readings on patches and of all grey levels, in the tangent at T_RC, scaled by the actual
  // residuals.
  const Matrix6& plane_information() const { return plane_information_; }
  const Matrix6& grey_information() const { return grey_information_; }

 private:
  static constexpr int kMinPairs = 100;

  // Returns whether the reference observes another surface there, in front, behind, or in a
  // neighbouring cell used for the interpolation of its grey level, or a dynamic object.
  bool IsHidden(const Eigen::Vector2d& uv, double z, double gate) const {
    const double most = gate + kSurfaceGateSigmas * noise_.Sigma(z);
    const cv::Point cell(static_cast<int>(uv.x()), static_cast<int>(uv.y()));
    for (const cv::Point& corner : {cv::Point(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
      const auto seen = static_cast<double>(reference_.depth_grid.at<float>(cell + corner));
      if (seen > 0.0 && std::abs(seen - z) > most) return true;
      if (seen > 0.0 && standing_.at<float>(cell + corner) <= 0.0F) return true;
    }
    return false;
  }

  GreyPairs Pair(const GreyImage& reference, const GreyImage& own, const Stage& stage) const {
    GreyPairs pairs;
    const cv::Mat& depth = features_.depth_grid;
    for (int v = 0; v < depth.rows; v += stage.spacing) {
      for (int u = 0; u < depth.cols; u += stage.spacing) {
        const float z = depth.at<float>(v, u);
        if (z <= 0.0F) continue;
        ++pairs.readings;
        const Eigen::Vector3d p_C = (z * grid_.Ray({u, v})).cast<double>();
        const Eigen::Vector3d p_R = T_RC_ * p_C;
        double value = 0.0;
        Eigen::Vector2d gradient;
        if (p_R.z() <= 0.0) continue;
        const Eigen::Vector2d uv = grid_.camera().Project(p_R);
        if (!reference.At(uv, &value, &gradient) || IsHidden(uv, p_R.z(), stage.gate)) continue;
        pairs.p_C.push_back(p_C);
        pairs.own.push_back(own.Of({u, v}));
        pairs.other.push_back(value);
      }
    }
    return pairs;
  }

  std::vector<GreyPoint> Weighed(const GreyPairs& pairs) {
    const GreyPairs::Likeness like = pairs.Compare();
    std::vector<double> errors;
    for (std::size_t i = 0; i < pairs.own.size(); ++i) {
      errors.push_back(std::abs(pairs.other[i] - like.gain * pairs.own[i] - like.offset));
    }
    grey_sigma_ = std::max(kMinGreySigma, 1.4826 * UpperMedian(errors));
    std::vector<GreyPoint> points;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      points.push_back({pairs.p_C[i], like.gain * pairs.own[i] + like.offset,
                        HuberFactor(errors[i] / grey_sigma_) / grey_sigma_});
    }
    return points;
  }

  std::vector<PointToPlaneRow> Weighed(std::vector<PointToPlaneRow> rows) const {
    const Eigen::Matrix3d R = T_RC_.R();
    for (PointToPlaneRow& row : rows) {
      row.inverse_sigma *= HuberFactor(row.Evaluate(R, T_RC_.p(), nullptr));
    }
    return rows;
  }

  void Measure(const AlignmentProblem& problem, const Vector6& x) {
    Eigen::VectorXd r(problem.NumResiduals());
    Eigen::Matrix<double, Eigen::Dynamic, 6> J(problem.NumResiduals(), 6);
    problem(x.data(), r.data(), J.data());
    const double error = r.squaredNorm() / std::max(1, problem.NumResiduals() - 6);
    const auto greys = static_cast<int>(r.size()) - planes_;
    const auto of_planes = J.topRows(planes_), of_greys = J.bottomRows(greys);
    plane_information_ = of_planes.transpose() * of_planes / std::max(1.0, error);
    grey_information_ = of_greys.transpose() * of_greys / std::max(1.0, error);
    plane_error_ = r.head(planes_).squaredNorm() / std::max(1, planes_);
    grey_error_ = grey_sigma_ * grey_sigma_ * r.tail(greys).squaredNorm() / std::max(1, greys);
  }

  const DepthGrid& grid_;
  const DepthNoise& noise_;
  const FrameFeatures& reference_;
  const cv::Mat& standing_;
  const FrameFeatures& features_;
  Pose T_RC_;
  GreyPairs::Likeness likeness_;
  int planes_ = 0;
  double last_step_ = 0.0;
  double overlap_ = 0.0;
  double grey_sigma_ = kMinGreySigma;
  double plane_error_ = 0.0, grey_error_ = 0.0;
  Matrix6 plane_information_ = Matrix6::Zero(), grey_information_ = Matrix6::Zero();
};

double MedianDepth(const cv::Mat& depth) {
  std::vector<double> readings;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      if (depth.at<float>(v, u) > 0.0F) readings.push_back(depth.at<float>(v, u));
    }
  }
  return readings.empty() ? 0.0 : UpperMedian(std::move(readings));
}

}  // namespace

DirectAligner::DirectAligner(const DepthGrid& grid, const DepthNoise& noise, double min_correlation,
                             int min_planes, double enough)
    : grid_(grid),
      noise_(noise),
      min_correlation_(min_correlation),
      min_planes_(min_planes),
      enough_(enough) {}

std::optional<DirectAlignment> DirectAligner::Align(const FrameFeatures& reference,
                                                    const cv::Mat& standing, const Pose& T_WR,
                                                    const FrameFeatures& features, const Pose& T_WC,
                                                    AlignmentStart start) const {
  if (reference.depth_grid.empty() || reference.gray_grid.empty()) return std::nullopt;
  const double depth = MedianDepth(features.depth_grid);
  if (depth <= 0.0 || features.gray_grid.empty()) return std::nullopt;
  const auto patches = FindPatches(standing, grid_, noise_);
  Alignment alignment(grid_, noise_, reference, standing, features, T_WR.Inverse() * T_WC);
  const std::span stages(kStages);
  for (Stage stage : stages.subspan(start == AlignmentStart::kAligned ? 1 : 0)) {
    stage.converged = std::max(stage.converged, enough_);
    if (!alignment.Refine(patches, stage)) return std::nullopt;
  }
  if (alignment.planes() < min_planes_) return std::nullopt;
  alignment.Compare();
  if (alignment.overlap() < kMinOverlap) return std::nullopt;
  if (alignment.correlation() < min_correlation_) return std::nullopt;
  // A step of the position is in R there, in W here.
  Matrix6 to_R = Matrix6::Identity();
  to_R.topLeftCorner<3, 3>() = T_WR.R().transpose();
  const Matrix6 planes = to_R.transpose() * alignment.plane_information() * to_R / kSharedNoise;
  const Matrix6 greys = to_R.transpose() * alignment.grey_information() * to_R;
  PoseConstraint known{T_WR * alignment.T_RC()};
  if (!FindUnobservableDirections(planes + greys / kSharedNoise, known.T_WC, depth,
                                  {.max_sigma = kMaxSigma})
           .empty()) {
    return std::nullopt;
  }
  const bool sees_most = alignment.overlap() >= kMostSeen;
  const Matrix6 information = planes + (sees_most ? greys : Matrix6(greys / kSharedNoise));
  known.sqrt_information = information.llt().matrixU();
  return DirectAlignment{known,
                         depth,
                         alignment.correlation(),
                         alignment.plane_error(),
                         alignment.grey_error(),
                         alignment.planes(),
                         alignment.overlap()};
}

}  // namespace highwall
