#include <highwall/core/sqrt_information.h>

#include <utility>

#include <Eigen/Cholesky>

#include <highwall/core/error.h>

namespace highwall::internal {

std::optional<Eigen::MatrixXd> TrySqrtInformation(const Eigen::MatrixXd& covariance,
                                                  std::string* fault) {
  const auto fail = [fault](const char* what) {
    *fault = std::string("SqrtInformation: the covariance is not ") + what;
    return std::nullopt;
  };
  if (covariance.rows() != covariance.cols() || covariance.rows() == 0) return fail("square");
  if (!covariance.allFinite()) return fail("finite");
  const double asymmetry = (covariance - covariance.transpose()).cwiseAbs().maxCoeff();
  if (!(asymmetry <= 1e-9 * covariance.cwiseAbs().maxCoeff())) return fail("symmetric");
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return fail("positive definite");
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols());
  return Eigen::MatrixXd(llt.matrixL().solve(identity));
}

Eigen::MatrixXd SqrtInformation(const Eigen::MatrixXd& covariance) {
  std::string fault;
  std::optional<Eigen::MatrixXd> root = TrySqrtInformation(covariance, &fault);
  HIGHWALL_REQUIRE(root, fault);
  return std::move(*root);
}

}  // namespace highwall::internal
