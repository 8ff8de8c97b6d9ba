#include <highwall/core/sqrt_information.h>

#include <Eigen/Cholesky>

#include <highwall/core/error.h>

namespace highwall::internal {

Eigen::MatrixXd SqrtInformation(const Eigen::MatrixXd& covariance) {
  HIGHWALL_REQUIRE(covariance.rows() == covariance.cols() && covariance.rows() > 0,
                   "SqrtInformation: the covariance is not square");
  HIGHWALL_REQUIRE(covariance.allFinite(), "SqrtInformation: the covariance is not finite");
  const double asymmetry = (covariance - covariance.transpose()).cwiseAbs().maxCoeff();
  HIGHWALL_REQUIRE(asymmetry <= 1e-9 * covariance.cwiseAbs().maxCoeff(),
                   "SqrtInformation: the covariance is not symmetric");
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  HIGHWALL_REQUIRE(llt.info() == Eigen::Success,
                   "SqrtInformation: the covariance is not positive definite");
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols());
  return llt.matrixL().solve(identity);
}

}  // namespace highwall::internal
