#include "support/reprojection_twins.h"

#include <cmath>

#include <ceres/autodiff_cost_function.h>

namespace highwall::twins {
namespace {

// Returns (a, b, c) of the line through two pixels, with (a, b) of unit length.
template <typename T>
Vector3<T> LineThrough(const Vector2<T>& s, const Vector2<T>& e) {
  const Vector3<T> l = s.homogeneous().cross(e.homogeneous());
  return l / l.template head<2>().norm();
}

// Returns the image of the line from a to b as (a, b, c) with (a, b) of unit length, oriented by a
// x b, also if one of the two is behind the camera.
template <typename T>
Vector3<T> Image(const PinholeCamera& camera, const Vector3<T>& a, const Vector3<T>& b) {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K.diagonal() << camera.fx, camera.fy, 1.0;
  K.col(2) << camera.cx, camera.cy, 1.0;
  const Eigen::Matrix<T, 3, 3> KT = K.cast<T>();
  const Vector3<T> l = Vector3<T>(KT * a).cross(Vector3<T>(KT * b));
  return l / l.template head<2>().norm();
}

// Segment or OrthonormalLine.
template <typename Twin>
std::unique_ptr<ceres::CostFunction> Make(const Twin& twin) {
  if (!twin.has_depth) {
    return std::make_unique<ceres::AutoDiffCostFunction<Twin, 2, 7, 6>>(new Twin(twin));
  }
  return std::make_unique<ceres::AutoDiffCostFunction<Twin, 4, 7, 6>>(new Twin(twin));
}

}  // namespace

template <int kRows>
template <typename T>
bool Point<kRows>::operator()(const T* T_WB, const T* p_W, T* residuals) const {
  const Vector3<T> p_C = rig.ToCamera<T>(T_WB, Vector3<T>(Eigen::Map<const Vector3<T>>(p_W)));
  Eigen::Map<Eigen::Matrix<T, kRows, 1>> r(residuals);
  r = W.template cast<T>() * (rig.Project<kRows, T>(p_C) - z.template cast<T>());
  return true;
}

template <typename T>
bool Segment::operator()(const T* T_WB, const T* segment, T* residuals) const {
  const Eigen::Vector2d s = observed.s.head<2>(), e = observed.e.head<2>();
  const double g = (observed.e.z() - observed.s.z()) / (e - s).norm();
  const double sigma_delta[2] = {noise.disparity_s, noise.disparity_e};
  const int rows = has_depth ? 2 : 1;
  for (int i = 0; i < 2; ++i) {
    const Vector3<T> p_W = Eigen::Map<const Vector3<T>>(segment + 3 * i);
    const Vector3<T> p_C = rig.ToCamera<T>(T_WB, p_W);
    const Vector2<T> uv = rig.Pixel<T>(p_C);
    residuals[rows * i] =
        LineThrough<double>(s, e).cast<T>().dot(Vector3<T>(uv.homogeneous())) / noise.px;
    if (!has_depth) continue;
    T& depth = residuals[rows * i + 1];
    if (weighting == Weighting::kPaper) {
      const Eigen::Vector2d s_R(s.x() - observed.s.z(), s.y()), e_R(e.x() - observed.e.z(), e.y());
      const Vector2<T> uv_R = rig.RightPixel<T>(p_C);
      depth =
          LineThrough<double>(s_R, e_R).cast<T>().dot(Vector3<T>(uv_R.homogeneous())) / noise.px;
    } else {
      // The measured disparity at the foot of the projected end, interpolated between s and e.
      const T t = (uv - s.cast<T>()).dot((e - s).cast<T>()) / (e - s).squaredNorm();
      const T measured = observed.s.z() + t * (observed.e.z() - observed.s.z());
      const double variance = sigma_delta[i] * sigma_delta[i] + g * g * noise.px * noise.px;
      depth = (rig.Disparity<T>(p_C) - measured) / std::sqrt(variance);
    }
  }
  return true;
}

template <typename T>
bool OrthonormalLine::operator()(const T* T_WB, const T* line, T* residuals) const {
  // Two points of the line in the camera frame: its foot from the origin of the world, and another
  // one.
  const Eigen::Matrix<T, 3, 3> U = Eigen::Map<const Eigen::Quaternion<T>>(line).toRotationMatrix();
  const Vector3<T> direction = U.col(1);
  const Vector3<T> foot_W = direction.cross(Vector3<T>(U.col(0))) * (line[4] / line[5]);
  const Vector3<T> a = rig.ToCamera<T>(T_WB, foot_W);
  const Vector3<T> b = rig.ToCamera<T>(T_WB, Vector3<T>(foot_W + direction));
  const Vector3<T> image = Image<T>(rig.camera, a, b);
  const double g = (observed.e.z() - observed.s.z()) / (observed.e - observed.s).head<2>().norm();
  const double sigma_delta[2] = {noise.disparity_s, noise.disparity_e};
  const int rows = has_depth ? 2 : 1;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d& end = i == 0 ? observed.s : observed.e;
    const Vector2<T> uv = end.head<2>().cast<T>();
    residuals[rows * i] = image.dot(Vector3<T>(uv.homogeneous())) / noise.px;
    if (!has_depth) continue;
    T& depth = residuals[rows * i + 1];
    if (weighting == Weighting::kPaper) {
      const Vector3<T> p_CV(T(rig.right.baseline), T(0), T(0));
      const Vector2<T> uv_R(T(end.x() - end.z()), T(end.y()));
      depth = Image<T>(rig.camera, Vector3<T>(a - p_CV), Vector3<T>(b - p_CV))
                  .dot(Vector3<T>(uv_R.homogeneous())) /
              noise.px;
    } else {
      // Disparity is affine along the image of a line.
      const Vector2<T> A = rig.Pixel<T>(a), AB = rig.Pixel<T>(b) - A;
      const T t = (uv - A).dot(AB) / AB.squaredNorm();
      const T seen = rig.Disparity<T>(a) + t * (rig.Disparity<T>(b) - rig.Disparity<T>(a));
      const double variance = sigma_delta[i] * sigma_delta[i] + g * g * noise.px * noise.px;
      depth = (seen - end.z()) / std::sqrt(variance);
    }
  }
  return true;
}

template <int kRows>
std::unique_ptr<ceres::CostFunction> MakePoint(const Point<kRows>& twin) {
  using Cost = ceres::AutoDiffCostFunction<Point<kRows>, kRows, 7, 3>;
  return std::make_unique<Cost>(new Point<kRows>(twin));
}
template std::unique_ptr<ceres::CostFunction> MakePoint(const Point<2>& twin);
template std::unique_ptr<ceres::CostFunction> MakePoint(const Point<3>& twin);

std::unique_ptr<ceres::CostFunction> MakeLine(const Segment& twin) {
  return Make(twin);
}

std::unique_ptr<ceres::CostFunction> MakeLine(const OrthonormalLine& twin) {
  return Make(twin);
}

}  // namespace highwall::twins
