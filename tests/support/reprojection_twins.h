#pragma once

#include <memory>

#include <ceres/cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/line_reprojection.h>

// Autodiff twins of the reprojection factors: the same residuals derived from the geometry, in a
// different way from the closed forms where possible. For tests and benchmarks. Their evaluation is
// compiled once, in the library highwall_factors_twins.
namespace highwall::twins {

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

// Camera, extrinsics and virtual right camera, as passed to the factors.
struct Rig {
  PinholeCamera camera;
  Pose T_BC;
  VirtualRightCamera right;

  // Returns p_C of p_W.
  template <typename T>
  Vector3<T> ToCamera(const T* T_WB, const Vector3<T>& p_W) const {
    const Eigen::Map<const Vector3<T>> p_WB(T_WB);
    const Eigen::Map<const Eigen::Quaternion<T>> q_WB(T_WB + 3);
    const Vector3<T> p_B = q_WB.conjugate() * (p_W - p_WB);
    return T_BC.q().conjugate().cast<T>() * (p_B - T_BC.p().cast<T>());
  }
  template <typename T>
  Vector2<T> Pixel(const Vector3<T>& p) const {
    return {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
  }
  // Returns the pixel of a point of C in the virtual right camera, which is `baseline` to the
  // right.
  template <typename T>
  Vector2<T> RightPixel(const Vector3<T>& p_C) const {
    return Pixel<T>(p_C - Vector3<T>(T(right.baseline), T(0), T(0)));
  }
  template <typename T>
  T Disparity(const Vector3<T>& p_C) const {
    return Pixel<T>(p_C).x() - RightPixel<T>(p_C).x();
  }
  // Returns (u, v) of a point of C, or (u, v, delta) with kRows = 3.
  template <int kRows, typename T>
  Eigen::Matrix<T, kRows, 1> Project(const Vector3<T>& p_C) const {
    Eigen::Matrix<T, kRows, 1> y;
    y.template head<2>() = Pixel<T>(p_C);
    if constexpr (kRows == 3) y(2) = Disparity<T>(p_C);
    return y;
  }
};

// kRows = 2: (u, v); kRows = 3: (u, v, delta).
template <int kRows>
struct Point {
  Rig rig;
  Eigen::Matrix<double, kRows, 1> z;
  Eigen::Matrix<double, kRows, kRows> W;

  template <typename T>
  bool operator()(const T* T_WB, const T* p_W, T* residuals) const;
};

// Parameters of the line factors.
struct ObservedLine {
  Rig rig;
  RgbdSegment observed;
  SegmentNoise noise;
  Weighting weighting = Weighting::kCovariance;
  bool has_depth = true;
};

struct Segment : ObservedLine {
  template <typename T>
  bool operator()(const T* T_WB, const T* segment, T* residuals) const;
};

struct OrthonormalLine : ObservedLine {
  template <typename T>
  bool operator()(const T* T_WB, const T* line, T* residuals) const;
};

template <int kRows>  // 2 or 3
std::unique_ptr<ceres::CostFunction> MakePoint(const Point<kRows>& twin);

// 4 rows with depth, 2 without.
std::unique_ptr<ceres::CostFunction> MakeLine(const Segment& twin);
std::unique_ptr<ceres::CostFunction> MakeLine(const OrthonormalLine& twin);

}  // namespace highwall::twins
