#include <memory>
#include <vector>

#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

#include "evaluate_bench.h"
#include "support/pose_twins.h"

namespace highwall::pose_bench {
namespace {

const bool registered = [] {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Matrix6 W = Matrix6::Identity() + 0.1 * Matrix6::Ones();
  const Pose a = Pose::FromTangent({1.0, 2.0, 0.5}, {0.4, 1.0, -0.7});
  const Pose b = Pose::FromTangent({1.5, 1.8, 0.7}, {0.2, 1.3, -0.5});
  const std::vector<double> block_a(a.data(), a.data() + Pose::kSize);
  const std::vector<double> block_b(b.data(), b.data() + Pose::kSize);
  RegisterEvaluate("PosePrior", std::make_shared<PosePrior>(b, W),
                   twins::Make(twins::PosePrior{b, W}), {block_a});
  RegisterEvaluate("RelativePose", std::make_shared<RelativePose>(a, W),
                   twins::Make(twins::RelativePose{a, W}), {block_a, block_b});
  const Vector6 x_0 = Vector6::Constant(0.1);
  RegisterEvaluate("VectorPrior<6>", std::make_shared<VectorPrior<6>>(x_0, W),
                   twins::Make(twins::Vector6Prior{x_0, W}), {std::vector<double>(6, 0.2)});
  return true;
}();

}  // namespace
}  // namespace highwall::pose_bench
