#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace [[gnu::visibility("default")]] highwall {
namespace internal {

// For normal equations of unit diagonal: a pivot below this marks a direction of the landmark that
// is unobservable from its factors. This value is then added to the diagonal, which keeps the
// landmark in place in that direction.
inline constexpr double kOpenPivot = 1e-8;

// The normal equations of one landmark, with its unknowns held constant.
template <int kDim>
struct LandmarkNormal {
  explicit LandmarkNormal(int dim) : H(dim, dim), inverse(dim, dim), g(dim), u(dim) {}

  // u = H^-1 g, with H damped by this fraction of its diagonal. Without damping H is changed only
  // if a direction is unobservable: the contributions of landmarks to the Schur complement must
  // cancel to the last digit in directions in which all variables move jointly.
  void Solve(double damping = 0.0) {
    const Eigen::Matrix<double, kDim, 1> scale =
        (H.diagonal().array() + 1e-300).sqrt().inverse().matrix();
    inverse = scale.asDiagonal() * H * scale.asDiagonal();
    inverse.diagonal().array() += damping;
    Eigen::LLT<Eigen::Matrix<double, kDim, kDim>> factors(inverse);
    open = factors.info() != Eigen::Success ||
           !(factors.matrixLLT().diagonal().cwiseAbs2().minCoeff() >= kOpenPivot);
    if (open) {
      inverse.diagonal().array() += kOpenPivot;
      factors.compute(inverse);
    }
    inverse.setIdentity();
    factors.solveInPlace(inverse);
    inverse = (scale.asDiagonal() * inverse * scale.asDiagonal()).eval();
    u.noalias() = inverse * g;
  }
  double Gain() const { return g.dot(u); }  // decrease of sum rho by a step of -u

  Eigen::Matrix<double, kDim, kDim> H, inverse;
  Eigen::Matrix<double, kDim, 1> g, u;
  double cost = 0.0;
  // A direction is unobservable, or a loss is convex, whose curvature is left out: H is not the
  // information.
  bool open = false;
};

}  // namespace internal
}  // namespace highwall
