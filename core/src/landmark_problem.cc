#include "landmark_problem.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "guarded_factor.h"

namespace highwall::internal {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

LandmarkProblem::Block Describe(const ceres::Problem& problem, double* values) {
  return {values, problem.ParameterBlockSize(values), problem.ParameterBlockTangentSize(values),
          problem.GetManifold(values)};
}

// Role of a block in the factors connected to it.
struct Role {
  std::size_t landmark = kNone;
  bool known = false;  // `argument` has been set
  LandmarkProblem::Argument argument;
};

// Converts residual blocks to factors.
class Splitter {
 public:
  Splitter(const ceres::Problem& problem, const std::vector<double*>& landmarks)
      : problem_(problem), landmarks_(landmarks) {
    roles_.reserve(2 * landmarks.size());
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      roles_[landmarks[i]] = {.landmark = i, .known = true, .argument = {}};
    }
  }

  void Add(ceres::ResidualBlockId residual) {
    problem_.GetParameterBlocksForResidualBlock(residual, &blocks_);
    std::size_t landmark = kNone;
    block_roles_.clear();
    for (const double* const block : blocks_) {
      block_roles_.push_back(&roles_[block]);
      landmark = std::min(landmark, block_roles_.back()->landmark);
    }
    if (landmark == kNone) {
      split_.others.push_back(residual);
      return;
    }
    landmark_of_.push_back(landmark);
    factors_.push_back({&Unguarded(*problem_.GetCostFunctionForResidualBlock(residual)),
                        problem_.GetLossFunctionForResidualBlock(residual),
                        split_.landmarks.arguments.size()});
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (!block_roles_[i]->known) Learn(blocks_[i], block_roles_[i]);
      split_.landmarks.arguments.push_back(block_roles_[i]->argument);
    }
  }

  // Groups the factors by landmark.
  SplitProblem Finish() {
    std::vector<std::size_t> ends(landmarks_.size() + 1, 0);
    for (const std::size_t landmark : landmark_of_) ++ends[landmark + 1];
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      ends[i + 1] += ends[i];
      if (ends[i + 1] == ends[i]) continue;
      split_.landmarks.landmarks.push_back(
          {Describe(problem_, landmarks_[i]), ends[i], ends[i + 1]});
    }
    split_.landmarks.factors.resize(factors_.size());
    for (std::size_t f = 0; f < factors_.size(); ++f) {
      split_.landmarks.factors[ends[landmark_of_[f]]++] = factors_[f];
    }
    return std::move(split_);
  }

 private:
  void Learn(double* block, Role* role) {
    role->known = true;
    if (problem_.IsParameterBlockConstant(block)) {
      role->argument.fixed = block;
    } else {
      role->argument.unknown = static_cast<int>(split_.landmarks.unknowns.size());
      split_.landmarks.unknowns.push_back(Describe(problem_, block));
    }
  }

  const ceres::Problem& problem_;
  const std::vector<double*>& landmarks_;
  std::unordered_map<const double*, Role> roles_;
  // One entry for each residual block with a landmark.
  std::vector<LandmarkProblem::Factor> factors_;
  std::vector<std::size_t> landmark_of_;
  // Of the current residual block.
  std::vector<double*> blocks_;
  std::vector<Role*> block_roles_;
  SplitProblem split_;
};

}  // namespace

SplitProblem Split(const ceres::Problem& problem, const std::vector<double*>& landmarks) {
  std::vector<ceres::ResidualBlockId> residuals;
  problem.GetResidualBlocks(&residuals);
  Splitter splitter(problem, landmarks);
  for (const ceres::ResidualBlockId residual : residuals) splitter.Add(residual);
  return splitter.Finish();
}

}  // namespace highwall::internal
