#include "inertial/joint_prior.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <ceres/problem.h>

#include <highwall/core/marginalization.h>
#include <highwall/core/sqrt_information.h>

namespace highwall {

bool AddJointPrior(const Eigen::MatrixXd& covariance, std::span<const VariableId> variables,
                   SlidingWindowSmoother* smoother) {
  std::string fault;
  const std::optional<Eigen::MatrixXd> root = internal::TrySqrtInformation(covariance, &fault);
  if (!root || !root->allFinite()) return false;
  const Eigen::MatrixXd& A = *root;
  std::vector<MarginalPrior::Block> blocks;
  const FactorGraph& graph = smoother->graph();
  for (const VariableId& id : variables) {
    const double* block = graph.Block(id);
    blocks.push_back({{block, block + graph.problem().ParameterBlockSize(block)},
                      graph.problem().GetManifold(block)});
  }
  smoother->AddFactorToBlocks(
      std::make_shared<MarginalPrior>(std::move(blocks), A, Eigen::VectorXd::Zero(A.rows())),
      nullptr, variables);
  return true;
}

}  // namespace highwall
