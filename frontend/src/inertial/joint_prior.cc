#include "inertial/joint_prior.h"

#include <memory>
#include <utility>
#include <vector>

#include <ceres/problem.h>

#include <highwall/core/marginalization.h>
#include <highwall/core/sqrt_information.h>

namespace highwall {

void AddJointPrior(const Eigen::MatrixXd& covariance, std::span<const VariableId> variables,
                   SlidingWindowSmoother* smoother) {
  std::vector<MarginalPrior::Block> blocks;
  const FactorGraph& graph = smoother->graph();
  for (const VariableId& id : variables) {
    const double* block = graph.Block(id);
    blocks.push_back({{block, block + graph.problem().ParameterBlockSize(block)},
                      graph.problem().GetManifold(block)});
  }
  const Eigen::MatrixXd A = SqrtInformation(covariance);
  smoother->AddFactorToBlocks(
      std::make_shared<MarginalPrior>(std::move(blocks), A, Eigen::VectorXd::Zero(A.rows())),
      nullptr, variables);
}

}  // namespace highwall
