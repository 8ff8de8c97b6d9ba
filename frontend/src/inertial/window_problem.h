#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "inertial/window_frames.h"
#include "inertial/window_graph.h"
#include "inertial/window_landmarks.h"
#include "inertial/window_values.h"

namespace highwall {

// The whole window as one cost function for Ceres, of one block: steps of the heads of all states,
// the newest tail and the calibrations, summed up from the start of a solve. The landmarks and the
// tails of older states are eliminated within. It has n + 1 residuals for n unknowns, with
//   |r|^2 = sum rho,   J^T J = H, the reduced equations,   J^T r = g, their gradient:
// J is the Cholesky factor. The last residual is the part that no step can change.
//
// The result of Evaluate() depends on earlier calls, so it is for one solver, on one thread. Memory
// is kept from one solve to the next.
class WindowProblem final : public ceres::CostFunction {
 public:
  // Solves for all variables and landmarks, and writes them. stop: polled between iterations.
  // Returns the reason why it cannot; empty if it did.
  std::string Solve(const std::atomic<bool>& stop, WindowGraph* graph, WindowLandmarks* landmarks);

  // Returns the covariance of the newest state, [pose, velocity, bias], gravity, the time offset
  // (zero if known), T_BC if it is unknown, and T_VW, as of the last solve; empty if one of their
  // directions is unobservable. A direction of a landmark may be.
  std::optional<Eigen::MatrixXd> Covariance() const;
  // Makes Covariance() that of the values, without a solve. Returns as Solve().
  std::string Linearize(WindowGraph* graph, WindowLandmarks* landmarks);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  // The problem at one x.
  struct Point {
    bool valid = false;
    Eigen::VectorXd x;
    WindowValues values;
    WindowFrames frames;
    WindowLandmarks::Estimates landmarks;
    double cost = 0.0;
    // Feedback of the inner rows to a step: L^T dy = -(l + B dx).
    Eigen::LLT<Eigen::MatrixXd> inner;
    Eigen::MatrixXd B;
    Eigen::VectorXd l;
    Eigen::MatrixXd H;  // reduced, lower triangle
    Eigen::VectorXd g, eliminated;
  };

  std::string Begin(WindowGraph* graph, WindowLandmarks* landmarks);
  bool MoveTo(const double* x) const;
  void StepTo(const Eigen::VectorXd& x) const;
  bool Reduce() const;
  void Accept() const;
  void WriteRows(double* residuals, double* jacobian) const;

  WindowGraph* graph_ = nullptr;
  WindowLandmarks* landmarks_ = nullptr;
  WindowLayout layout_;
  WindowUnknowns unknowns_;  // of the last solve, after which the graph may have been moved
  // They change in Evaluate(), which is const to Ceres.
  mutable Point accepted_, trial_;
  mutable int trials_ = 0;  // from the accepted point
  mutable std::string fault_;
  mutable WindowNormal normal_;
  mutable FrameSystem system_;
  mutable Eigen::VectorXd step_, frame_step_;
  mutable Eigen::LLT<Eigen::MatrixXd> factors_;  // of the accepted H
};

}  // namespace highwall
