// Uses core alone: a prior and an odometry measurement, solved; exits 0 if the answer is right.
#include <memory>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

int main() {
  using namespace highwall;
  const Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Identity();
  const Pose step = Pose::FromTangent({1, 0, 0}, {0, 0, 0.5});
  FactorGraph graph;
  const Variable<Pose> a = graph.AddVariable(Pose());
  const Variable<Pose> b = graph.AddVariable(Pose());
  graph.AddFactor(std::make_unique<PosePrior>(Pose(), W), a);
  graph.AddFactor(std::make_unique<RelativePose>(step, W), a, b);
  const SolveSummary summary = graph.Solve();
  const bool right = (graph.Value(b).p() - step.p()).norm() < 1e-6;
  return summary.IsUsable() && right ? 0 : 1;
}
