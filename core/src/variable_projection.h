#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/internal/landmark_normal.h>

#include "guarded_factor.h"
#include "landmark_problem.h"

namespace highwall::internal {

// All factors of landmarks as one cost function of the unknowns (variable projection): at each x
// the landmarks are optimized by a few Gauss-Newton steps of their own. It has n + 1 residuals for
// n tangent dimensions of the unknowns, with
//   |r|^2 = sum rho,   J^T J = H, the Schur complement,   J^T r = g, its gradient,
// so that a solver without the landmarks takes the same steps as one with them. The last residual
// is the part that no step of the unknowns can change; its Jacobian is zero.
//
// With damping each landmark instead takes the step of the joint linear system, with its diagonal
// increased by this fraction, and damped steps of its own only if it is then far from its minimum:
// H is the Schur complement of the damped landmarks. A landmark whose step fails is damped more, by
// itself, until its steps succeed again.
//
// Landmarks start from their values at the x of the last evaluation with Jacobians, so the result
// of Evaluate() depends on earlier calls: for one solver, on one thread. Losses must be concave
// (rho'' <= 0).
class VariableProjection final : public ceres::CostFunction {
 public:
  struct Memory;

  // The objects referred to by the problem, faults and memory must outlive it. Memory: reused from
  // one solve to the next, by one object at a time. damping: >= 0; 0: variable projection.
  VariableProjection(LandmarkProblem problem, double damping, FactorFaults* faults, Memory* memory);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  // Adds H at the current values of the blocks to the upper triangle of `sum`, whose first columns
  // are the tangent spaces of the unknowns: the H of the solver if it ended there and damped no
  // landmark. For a projection without damping. Adds to `eliminated` the part of the diagonal of H
  // that the landmarks removed, relative to which the rest may be rounding. Returns false if a
  // factor cannot be evaluated, if a direction of a landmark is unobservable, or if a loss is
  // convex.
  bool AddInformation(Eigen::MatrixXd* sum, Eigen::VectorXd* eliminated) const;

  // Writes the landmarks of the last evaluation with Jacobians to their blocks.
  void WriteLandmarks() const;

  const std::vector<LandmarkProblem::Block>& unknowns() const { return problem_.unknowns; }
  // Whether steps of the landmarks alone are predicted to decrease the cost by at most this
  // fraction of it, after the last evaluation with Jacobians; always true without damping.
  bool LandmarksRest(double fraction) const;
  // Whether the next step of the unknowns, without damping, is predicted to decrease the cost of
  // the landmarks' factors by at most this fraction of it.
  bool UnknownsRest(double fraction) const;

 private:
  // Row-major matrix with kDim columns, as in Ceres, of fixed or dynamic size.
  template <int kDim, int kRows = Eigen::Dynamic>
  using Matrix = Eigen::Matrix<double, kRows, kDim, kDim == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  template <int kDim, int kRows = Eigen::Dynamic>
  using ConstRows = Eigen::Map<const Matrix<kDim, kRows>>;
  template <int kDim, int kRows = Eigen::Dynamic>
  using MutableRows = Eigen::Map<Matrix<kDim, kRows>>;

  void LayOut(const LandmarkProblem::Landmark& landmark);
  template <class State>
  bool IsAt(const State& state, double const* const* parameters) const;
  bool MoveTo(double const* const* parameters) const;
  bool PrepareUnknowns() const;
  template <int kDim>
  bool SolveLandmark(std::size_t index) const;
  template <int kDim>
  bool FitLandmark(std::size_t index, double* value, LandmarkNormal<kDim>* normal) const;
  template <int kDim>
  bool Settle(const LandmarkProblem::Landmark& landmark, double* value, double* damping,
              LandmarkNormal<kDim>* normal) const;
  template <int kDim>
  bool Descend(const LandmarkProblem::Landmark& landmark, double* value,
               LandmarkNormal<kDim>* normal) const;
  template <int kDim>
  void Follow(std::size_t index, double* value) const;
  template <int kDim>
  bool Stay(std::size_t index, double* value, bool followed, LandmarkNormal<kDim>* normal) const;
  template <int kDim>
  bool Linearize(const LandmarkProblem::Landmark& landmark, const double* value, double damping,
                 LandmarkNormal<kDim>* normal) const;
  // Records that the factor could not be evaluated; returns false.
  bool Fail(const LandmarkProblem::Factor& factor) const;
  const double* EvaluateFactor(const LandmarkProblem::Factor& factor, const double* landmark,
                               double* out) const;
  template <int kDim>
  void Accumulate(std::size_t index) const;
  template <int kDim, int kRows>
  void AccumulateFactor(int coupled, const LandmarkProblem::Factor& factor, double weight,
                        const double* numbers, const ConstRows<kDim, kRows>& J_landmark) const;
  template <int kTangent, int kRows>
  void ToTangent(std::size_t unknown, const double* ambient, MutableRows<kTangent, kRows>* J) const;
  template <int kTangent, int kRows>
  void AddPair(const MutableRows<kTangent, kRows>& J, std::size_t unknown, std::size_t k,
               std::size_t other) const;
  template <int kDim>
  void Eliminate(std::size_t index, const LandmarkNormal<kDim>& normal) const;
  void WriteRows(double* residuals, double** jacobians) const;

  LandmarkProblem problem_;
  const double damping_;
  FactorFaults* const faults_;
  Memory& memory_;  // changes in Evaluate(), which is const to Ceres
};

struct VariableProjection::Memory {
  struct Coupling {
    int unknown;
    int column;  // among the columns of its landmark
  };
  // Offsets of the data of a landmark.
  struct Layout {
    std::size_t first_coupling = 0, end_coupling = 0;  // by ascending unknowns
    std::size_t value = 0;                             // in State::landmarks
    std::size_t feedback = 0;                          // in State::feedback
    int coupled = 0;                                   // tangent dimensions of its unknowns
  };
  // The landmarks at one x, and the system reduced by them.
  struct State {
    bool valid = false;
    bool open = false;              // a landmark has an unobservable direction
    std::vector<double> x;          // blocks of the unknowns
    std::vector<double> landmarks;  // blocks of the landmarks
    std::vector<double> costs;      // sum of rho of each landmark's factors
    std::vector<double> damping;    // of each landmark, as a fraction of its diagonal
    // Feedback of each landmark to a step, dl = -u - W dx: u, then W, column by column.
    std::vector<double> feedback;
    Eigen::MatrixXd H;  // upper triangle
    Eigen::VectorXd g;
    Eigen::VectorXd eliminated;  // part that the landmarks removed from the diagonal of H
    double cost = 0.0;           // sum of rho
    double gain = 0.0;           // predicted decrease of `cost` by steps of the landmarks alone

    // Begins the sums over the landmarks.
    void Clear() {
      H.setZero(), g.setZero(), eliminated.setZero();
      cost = gain = 0.0;
      open = false;
    }
  };

  std::vector<Layout> layouts;  // of the landmarks
  std::vector<Coupling> couplings;
  std::vector<int> column_of;      // of each argument that is an unknown: its Coupling::column
  std::vector<int> column;         // of each unknown in H
  std::vector<std::size_t> place;  // of each unknown in State::x
  // The current state of Ceres, and the trial of its next step.
  State accepted, trial;
  int trials = 0;         // from the accepted state
  double decrease = 0.0;  // of the accepted state's cost, predicted for the next step
  // For each factor SilentRows() at the start of the solve; whether the solve is starting.
  std::vector<std::uint64_t> silent;
  bool begins = false;
  std::vector<Matrix<-1>> plus;  // of each unknown, at the trial's x
  Eigen::VectorXd step;          // from the accepted state to the trial

  // Of the current landmark.
  std::vector<double> numbers;      // of each factor: residuals, ambient Jacobians
  std::vector<double> of_landmark;  // tangent Jacobians with respect to it, row by row
  std::vector<double> weights;      // rho' of each factor
  std::vector<double> coupling;     // H_lx, column by column
  std::vector<double> landmark_plus;
  std::vector<double> tried;  // value
  // Of the current factor.
  std::vector<double> tangent;   // Jacobians with respect to its unknowns, one by one
  std::vector<double> weighted;  // the last of them, times the weight
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
};

inline bool VariableProjection::LandmarksRest(double fraction) const {
  return damping_ == 0.0 || memory_.accepted.gain <= fraction * memory_.accepted.cost;
}

inline bool VariableProjection::UnknownsRest(double fraction) const {
  return memory_.decrease <= fraction * memory_.accepted.cost;
}

}  // namespace highwall::internal
