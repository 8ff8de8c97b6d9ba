#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "inertial/window_values.h"

namespace highwall {

// Normal equations of a joint tangent vector: H dx = -g, with the sum of rho(|r|^2).
struct WindowNormal {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  // Part of the diagonal of H that landmarks removed, relative to which the rest may be rounding.
  Eigen::VectorXd eliminated;
  double cost = 0.0;

  void Reset(int size);
};

// Where an image was taken: its camera is at the end of the readings in a state, moved by the
// change of the time offset since.
struct WindowImage {
  Eigen::Vector3d v_V = Eigen::Vector3d::Zero();      // [m/s]
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s]
  double time_offset = 0.0;                           // [s] applied to its stamp
};

// Landmarks are observed from frames: camera i, of state i, has index 2 i, and the map at that
// state, T_VW, index 2 i + 1. A step of a frame is one of PoseManifold.
inline constexpr int CameraFrame(int state) {
  return 2 * state;
}
inline constexpr int MapFrame(int state) {
  return 2 * state + 1;
}
inline constexpr bool IsCamera(int frame) {
  return frame % 2 == 0;
}

struct WindowFrame {
  Pose T_VF;
  Eigen::Matrix3d R_FV;
  Eigen::Vector3d p_VF;
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;  // PlusJacobian of T_VF
};

// Derivatives of a camera's step in those of T_VB and of [time_offset, T_BC], as far as unknown.
struct CameraJacobian {
  Eigen::Matrix<double, 6, 6> of_body;
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 7> of_calibration;
};

struct WindowFrames {
  std::vector<WindowFrame> frames;
  std::vector<CameraJacobian> cameras;  // of each state

  // images: one for each state.
  void MoveTo(const WindowValues& values, const std::vector<WindowImage>& images,
              const WindowUnknowns& unknowns);
  // Writes the steps of all frames, 6 rows each, that follow from a step of the values.
  void StepsOf(const Eigen::VectorXd& step, const WindowLayout& layout,
               Eigen::VectorXd* of_frames) const;
};

// Normal equations of the frames, in blocks of fixed size.
class FrameSystem {
 public:
  using Block = Eigen::Matrix<double, 6, 6>;
  using Segment = Eigen::Matrix<double, 6, 1>;

  void Reset(int frames);
  // row <= column.
  Block& H(int row, int column) { return H_[Index(row, column)]; }
  Segment& g(int frame) { return g_[static_cast<std::size_t>(frame)]; }
  Segment& eliminated(int frame) { return eliminated_[static_cast<std::size_t>(frame)]; }

  // Adds the equations in the variables that the frames depend on.
  void AddTo(const WindowFrames& frames, const WindowLayout& layout, WindowNormal* normal) const;

 private:
  std::size_t Index(int row, int column) const {
    return static_cast<std::size_t>(row * frames_ + column);
  }
  void AddCalibration(const WindowFrames& frames, const WindowLayout& layout,
                      WindowNormal* normal) const;

  int frames_ = 0;
  std::vector<Block> H_;
  std::vector<Segment> g_, eliminated_;
};

}  // namespace highwall
