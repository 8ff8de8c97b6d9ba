#include "inertial/innovation.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <highwall/core/so3.h>

namespace highwall {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Returns the difference in the tangent of PoseManifold at `from`.
Vector6 Difference(const Pose& from, const Pose& to) {
  Vector6 difference;
  difference << to.p() - from.p(), so3::Log(from.q().conjugate() * to.q());
  return difference;
}

}  // namespace

std::optional<double> SquaredInnovation(const CameraPoseEstimate& predicted,
                                        const VisualPose& visual) {
  const Matrix6 information = visual.sqrt_information.transpose() * visual.sqrt_information;
  const Eigen::LLT<Matrix6> llt(information);
  // There is no innovation if a direction is unobservable.
  if (llt.info() != Eigen::Success || llt.matrixLLT().diagonal().minCoeff() < 1.0) {
    return std::nullopt;
  }
  const Vector6 e = Difference(predicted.T_WC, visual.T_WC);
  const Matrix6 S = predicted.covariance + Matrix6(llt.solve(Matrix6::Identity()));
  return e.dot(S.ldlt().solve(e));
}

bool AreReadingsContradicted(double squared_innovation, const CameraPoseEstimate& predicted,
                             const Pose& T_WC, const Pose& steady, bool known_bad) {
  constexpr double kBeyondNoise = 100.0;  // ten standard deviations
  constexpr double kUnlikely = 16.81;     // 99 % of chi-squared of six degrees of freedom
  if (!(squared_innovation > (known_bad ? kUnlikely : kBeyondNoise))) return false;
  const auto departure = [&](const Pose& pose) {
    const Vector6 e = Difference(steady, pose);
    return e.dot(predicted.covariance.ldlt().solve(e));
  };
  return departure(predicted.T_WC) > departure(T_WC);
}

}  // namespace highwall
