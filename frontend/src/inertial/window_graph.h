#pragma once

#include <memory>
#include <string>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "inertial/window_frames.h"
#include "inertial/window_values.h"

namespace highwall {

// A factor on variables of the window, which are given by kind and index of the state.
struct WindowFactor {
  enum class Kind { kBody, kMap, kVelocity, kBias, kGravityDirection };
  struct Variable {
    Kind kind;
    int state = 0;
  };

  const char* name = "";  // its type
  std::unique_ptr<const ceres::CostFunction> cost;
  std::vector<Variable> variables;
};

// Gaussian prior of the oldest states and of the calibrations, |r|^2 = d^T H d + 2 g^T d + constant
// with d = x [-] at, in the order by state. The constant makes the minimum zero.
struct WindowPrior {
  WindowValues at;
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double constant = 0.0;
};

// The variables of VisualInertialWindow and all factors but those of landmarks.
struct WindowGraph {
  WindowUnknowns unknowns;
  WindowValues values;
  std::vector<WindowImage> images;                 // of each state
  std::vector<std::vector<WindowFactor>> factors;  // of each state, on it and the one before
  WindowPrior prior;

  int states() const { return static_cast<int>(values.states.size()); }
  // Adds prior and factors at these values to the equations. Returns why a factor
  // cannot be evaluated; empty if all could.
  std::string AddTo(const WindowValues& at, const WindowLayout& layout, WindowNormal* normal) const;
  // Marginalizes the oldest state with its factors. landmarks: equations of its landmarks in the
  // order by state; output: scratch memory. Returns as AddTo().
  std::string RemoveOldest(WindowNormal* normal);

 private:
  void AddPrior(const WindowValues& at, const WindowLayout& layout, WindowNormal* normal) const;
};

}  // namespace highwall
