#include "landmark_problem.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace highwall::internal {

int NumbersOf(const ceres::CostFunction& cost) {
  const std::vector<int>& sizes = cost.parameter_block_sizes();
  return cost.num_residuals() * std::accumulate(sizes.begin(), sizes.end(), 1);
}

LandmarkProblemBuilder::LandmarkProblemBuilder(std::vector<Variable> variables)
    : variables_(std::move(variables)), unknown_of_(variables_.size(), -1) {}

bool LandmarkProblemBuilder::Add(const ceres::CostFunction& cost, const ceres::LossFunction* loss,
                                 std::span<const VariableId> variables) {
  const auto is_landmark = [&](const VariableId& id) {
    return variables_[id.index].landmark && !variables_[id.index].fixed;
  };
  const auto landmark = std::ranges::find_if(variables, is_landmark);
  if (landmark == variables.end()) return false;
  landmark_of_.push_back(landmark->index);
  factors_.push_back({&cost, loss, problem_.arguments.size()});
  for (const VariableId& id : variables) {
    const Variable& variable = variables_[id.index];
    LandmarkProblem::Argument argument;
    if (variable.fixed) {
      argument.fixed = variable.block.values;
    } else if (!variable.landmark) {
      int& unknown = unknown_of_[id.index];
      if (unknown < 0) {
        unknown = static_cast<int>(problem_.unknowns.size());
        problem_.unknowns.push_back(variable.block);
      }
      argument.unknown = unknown;
    }
    problem_.arguments.push_back(argument);
  }
  return true;
}

LandmarkProblem LandmarkProblemBuilder::Finish() {
  std::vector<std::size_t> ends(variables_.size() + 1, 0);
  for (const std::size_t landmark : landmark_of_) ++ends[landmark + 1];
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    ends[i + 1] += ends[i];
    if (ends[i + 1] == ends[i]) continue;
    problem_.landmarks.push_back({variables_[i].block, ends[i], ends[i + 1]});
  }
  problem_.factors.resize(factors_.size());
  for (std::size_t f = 0; f < factors_.size(); ++f) {
    problem_.factors[ends[landmark_of_[f]]++] = factors_[f];
  }
  return std::move(problem_);
}

}  // namespace highwall::internal
