#include <highwall/core/testing/jacobian_check.h>

#include <functional>
#include <limits>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/so3.h>

namespace highwall::jacobian_check_test {
namespace {

using testing::CheckJacobians;
using testing::JacobianCheckOptions;
using testing::JacobianCheckResult;

using Matrix37 = Eigen::Matrix<double, 3, 7, Eigen::RowMajor>;
using Matrix33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// r = R(q) x + p with correct Jacobians. `tamper` then corrupts the output.
class Transform final : public ceres::SizedCostFunction<3, 7, 3> {
 public:
  using Tamper = std::function<void(double const* const*, double*, double**)>;

  explicit Transform(Tamper tamper = nullptr) : tamper_(std::move(tamper)) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Pose T = Pose::FromBlock(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> x(parameters[1]);
    Eigen::Map<Eigen::Vector3d> r(residuals);
    r = T * Eigen::Vector3d(x);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Matrix<double, 3, 6> J;
      J << Eigen::Matrix3d::Identity(), -T.R() * so3::Hat(x);
      PoseManifold::Lift<3>(parameters[0], J, jacobians[0]);
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      Eigen::Map<Matrix33> J(jacobians[1]);
      J = T.R();
    }
    if (tamper_) tamper_(parameters, residuals, jacobians);
    return true;
  }

 private:
  const Tamper tamper_;
};

JacobianCheckResult Check(const ceres::CostFunction& factor,
                          const JacobianCheckOptions& options = {}) {
  const PoseManifold manifold;
  const Pose T = Pose::FromTangent({1.0, -2.0, 0.5}, {0.4, -0.9, 1.3});
  return CheckJacobians(factor, {{T.data(), T.data() + 7}, {0.3, -1.1, 2.0}}, {&manifold, nullptr},
                        options);
}

TEST(JacobianCheck, AcceptsCorrectJacobians) {
  const JacobianCheckResult result = Check(Transform());
  EXPECT_TRUE(result) << result.message;
  EXPECT_TRUE(result.message.empty());
}

TEST(JacobianCheck, CatchesAFlippedSignAndNamesTheBlock) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const*, double*, double** jacobians) {
        if (jacobians && jacobians[1]) jacobians[1][4] *= -1.0;
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("block 1"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("central differences"), std::string::npos) << result.message;
}

TEST(JacobianCheck, CatchesATangentJacobianInAmbientSlots) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const* parameters, double*, double** jacobians) {
        if (!jacobians || !jacobians[0]) return;
        const Eigen::Map<const Eigen::Vector3d> x(parameters[1]);
        Eigen::Map<Matrix37> J(jacobians[0]);
        J << Eigen::Matrix3d::Identity(), -Pose::FromBlock(parameters[0]).R() * so3::Hat(x),
            Eigen::Vector3d::Zero();
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("block 0"), std::string::npos) << result.message;
}

TEST(JacobianCheck, CatchesAnUnwrittenEntry) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const*, double*, double** jacobians) {
        if (jacobians && jacobians[1]) {
          jacobians[1][2] = std::numeric_limits<double>::quiet_NaN();  // its initial value
        }
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("not written"), std::string::npos) << result.message;
}

TEST(JacobianCheck, CatchesAnUnwrittenResidual) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const*, double* residuals, double**) {
        residuals[1] = std::numeric_limits<double>::quiet_NaN();
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("residual"), std::string::npos) << result.message;
}

TEST(JacobianCheck, CatchesResidualsThatChangeWhenJacobiansAreRequested) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const*, double* residuals, double** jacobians) {
        if (jacobians) residuals[0] += 1e-6;
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("residuals change"), std::string::npos) << result.message;
}

TEST(JacobianCheck, CatchesABlockThatDiffersWhenRequestedAlone) {
  const JacobianCheckResult result =
      Check(Transform([](double const* const*, double*, double** jacobians) {
        if (jacobians && jacobians[1] && !jacobians[0]) jacobians[1][0] += 1e-3;
      }));
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("alone"), std::string::npos) << result.message;
}

class Refusing final : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(double const* const*, double*, double**) const override { return false; }
};

TEST(JacobianCheck, FailsWhereEvaluateReturnsFalse) {
  const JacobianCheckResult result = CheckJacobians(Refusing(), {{0.0}}, {nullptr});
  EXPECT_FALSE(result);
  EXPECT_NE(result.message.find("returned false"), std::string::npos) << result.message;
}

TEST(JacobianCheck, ThrowsOnBlocksThatAreNotTheFactors) {
  const PoseManifold pose;
  const std::vector<double> x(7, 0.5), y(3, 0.0);
  EXPECT_THROW(CheckJacobians(Transform(), {x}, {&pose}), InvalidArgument);
  EXPECT_THROW(CheckJacobians(Transform(), {x, y}, {&pose}), InvalidArgument);
  EXPECT_THROW(CheckJacobians(Transform(), {x, x}, {&pose, nullptr}), InvalidArgument);
  EXPECT_THROW(CheckJacobians(Transform(), {x, y}, {nullptr, &pose}), InvalidArgument);
}

TEST(JacobianCheck, ThrowsOnBadOptions) {
  EXPECT_THROW(Check(Transform(), {.step = 0.0}), InvalidArgument);
  EXPECT_THROW(Check(Transform(), {.absolute = -1.0}), InvalidArgument);
  EXPECT_THROW(Check(Transform(), {.relative = -1.0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::jacobian_check_test
