#pragma once

#include <cstddef>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

namespace highwall::internal {

// Landmarks with all their factors. A factor depends on one landmark, on unknowns (any other
// variables) and on fixed blocks.
struct LandmarkProblem {
  struct Block {
    double* values = nullptr;
    int size = 0;
    int tangent_size = 0;
    const ceres::Manifold* manifold = nullptr;  // null: Euclidean
  };
  // A block of a factor: an unknown, a fixed block, or else the landmark.
  struct Argument {
    int unknown = -1;
    const double* fixed = nullptr;

    bool IsLandmark() const { return unknown < 0 && fixed == nullptr; }
  };
  struct Factor {
    const ceres::CostFunction* cost = nullptr;
    const ceres::LossFunction* loss = nullptr;  // null: none
    std::size_t first_argument = 0;             // in `arguments`
  };
  struct Landmark {
    Block block;
    std::size_t first_factor = 0, end_factor = 0;  // in `factors`
  };
  std::vector<Block> unknowns;
  std::vector<Landmark> landmarks;
  std::vector<Factor> factors;
  std::vector<Argument> arguments;
};

// The part of a problem that depends on `landmarks` (blocks that are not constant, no two of which
// share a residual), and the remaining residuals. Both in the order of the problem's residuals; a
// landmark without residuals is left out.
struct SplitProblem {
  LandmarkProblem landmarks;
  std::vector<ceres::ResidualBlockId> others;
};
SplitProblem Split(const ceres::Problem& problem, const std::vector<double*>& landmarks);

}  // namespace highwall::internal
