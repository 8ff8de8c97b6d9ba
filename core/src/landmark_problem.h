#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>

#include <highwall/core/variable.h>

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

// Returns the number of residuals and Jacobian entries of a factor.
int NumbersOf(const ceres::CostFunction& cost);

// Makes a LandmarkProblem of the factors of a graph.
class LandmarkProblemBuilder {
 public:
  struct Variable {
    LandmarkProblem::Block block;
    bool fixed = false;
    bool landmark = false;
  };
  // variables: of the graph, by VariableId::index.
  explicit LandmarkProblemBuilder(std::vector<Variable> variables);

  // Adds a factor that depends on a landmark which is not fixed; no factor may depend on two. Does
  // nothing and returns false for any other factor.
  bool Add(const ceres::CostFunction& cost, const ceres::LossFunction* loss,
           std::span<const VariableId> variables);

  // Landmarks are in the order of the variables, factors and unknowns in the order in which they
  // were added. A landmark without factors is left out.
  LandmarkProblem Finish();

 private:
  const std::vector<Variable> variables_;
  std::vector<int> unknown_of_;  // by variable; -1: not known yet
  // One entry for each factor.
  std::vector<LandmarkProblem::Factor> factors_;
  std::vector<std::size_t> landmark_of_;  // index of its variable
  LandmarkProblem problem_;
};

}  // namespace highwall::internal
