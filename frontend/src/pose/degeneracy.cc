#include "pose/degeneracy.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>

namespace highwall {

std::vector<UnobservableDirection> FindUnobservableDirections(
    const Eigen::Matrix<double, 6, 6>& information, const Pose& T_WC, double depth,
    const DegeneracyOptions& options) {
  HIGHWALL_REQUIRE(std::isfinite(depth) && depth > 0.0,
                   "FindUnobservableDirections: depth must be positive");
  HIGHWALL_REQUIRE(information.allFinite(),
                   "FindUnobservableDirections: the information must be finite");
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  // From metres in C to the tangent: position in W, rotation in C.
  Matrix6 S = Matrix6::Zero();
  S.topLeftCorner<3, 3>() = T_WC.R();
  S.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() / depth;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(S.transpose() * information * S);
  const double least = 1.0 / (options.max_sigma * options.max_sigma);
  // Threshold of rounding errors.
  const double nothing = 1e-14 * eigen.eigenvalues()(5);
  std::vector<UnobservableDirection> open;
  for (int i = 0; i < 6; ++i) {
    const double h = eigen.eigenvalues()(i);
    if (h >= least) break;  // in ascending order
    open.push_back({eigen.eigenvectors().col(i).head<3>(), eigen.eigenvectors().col(i).tail<3>(),
                    h > nothing ? 1.0 / std::sqrt(h) : std::numeric_limits<double>::infinity()});
  }
  return open;
}

}  // namespace highwall
