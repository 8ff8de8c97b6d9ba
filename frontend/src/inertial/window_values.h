#pragma once

#include <vector>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall {

// A state of VisualInertialWindow. Its tangent vector has a head, [T_VB, T_VW], which landmarks
// depend on, and a tail, [velocity, bias].
struct WindowState {
  static constexpr int kHead = 12, kTail = 9;

  Pose T_VB, T_VW;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  ImuBias bias = ImuBias::Zero();
};

// Values of all variables but the landmarks.
struct WindowValues {
  std::vector<WindowState> states;  // oldest first
  UnitDirection gravity;
  double time_offset = 0.0;  // [s]
  Pose T_BC;

  bool IsFinite() const;
};

// Which calibrations are estimated besides gravity's direction.
struct WindowUnknowns {
  bool time_offset = true;
  bool T_BC = false;

  int size() const { return (time_offset ? 1 : 0) + (T_BC ? 6 : 0); }
};

// Rows of the variables in a joint tangent vector.
struct WindowLayout {
  static constexpr int kGravity = 2;  // rows

  std::vector<int> head, tail;  // of each state
  int gravity = 0;
  int cameras = 0;  // of [time_offset, T_BC], as far as they are unknown
  int inner = 0;    // number of the first rows that a solver may eliminate: tails of old states
  int size = 0;

  // [head, tail] of each state, then the calibrations.
  void OrderByState(int states, const WindowUnknowns& unknowns);
  // The tails of all states but the newest first, then the heads, the newest tail, the
  // calibrations.
  void OrderForSolver(int states, const WindowUnknowns& unknowns);
  int T_BC(const WindowUnknowns& unknowns) const {
    return cameras + (unknowns.time_offset ? 1 : 0);
  }
};

// Writes from [+] step. to: with any values.
void Plus(const WindowValues& from, const Eigen::VectorXd& step, const WindowLayout& layout,
          const WindowUnknowns& unknowns, WindowValues* to);

// Writes values [-] from for the states of `from`, in its order by state.
void Minus(const WindowValues& values, const WindowValues& from, const WindowLayout& layout,
           const WindowUnknowns& unknowns, Eigen::VectorXd* step);

}  // namespace highwall
