#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace highwall::internal {

// Of normal equations of unit diagonal: what is left of a pivot below this is a direction that the
// factors of a landmark leave open, and this is added to them then, which keeps it where it is.
inline constexpr double kOpenPivot = 1e-8;

// The normal equations of a landmark alone, its unknowns held.
template <int kDim>
struct LandmarkNormal {
  explicit LandmarkNormal(int dim) : H(dim, dim), inverse(dim, dim), g(dim), u(dim) {}

  // u = H^-1 g, H damped where a direction is open and nowhere else: what landmarks add to the
  // Schur complement must cancel to the last digit in directions in which all move along.
  void Solve() {
    const Eigen::Matrix<double, kDim, 1> scale =
        (H.diagonal().array() + 1e-300).sqrt().inverse().matrix();
    inverse = scale.asDiagonal() * H * scale.asDiagonal();
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
  double Gain() const { return g.dot(u); }  // of sum rho, by a step of -u

  Eigen::Matrix<double, kDim, kDim> H, inverse;
  Eigen::Matrix<double, kDim, 1> g, u;
  double cost = 0.0;
  bool open = false;  // a direction of it
};

}  // namespace highwall::internal
