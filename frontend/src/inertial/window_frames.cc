#include "inertial/window_frames.h"

#include <Eigen/Geometry>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

int FirstRow(int frame, const WindowLayout& layout) {
  return layout.head[static_cast<std::size_t>(frame / 2)] + (IsCamera(frame) ? 0 : 6);
}

WindowFrame FrameAt(const Pose& T_VF) {
  WindowFrame frame{T_VF, T_VF.R().transpose(), T_VF.p(), {}};
  PoseManifold().PlusJacobian(T_VF.data(), frame.plus.data());
  return frame;
}

// Moves the camera of an image. jacobian: output.
Pose CameraAt(const WindowState& state, const WindowImage& image, const WindowValues& values,
              const WindowUnknowns& unknowns, CameraJacobian* jacobian) {
  const double dt = unknowns.time_offset ? values.time_offset - image.time_offset : 0.0;
  const Eigen::Quaterniond turn = so3::Exp(image.omega_B * dt), q_BC = values.T_BC.q();
  const Eigen::Quaterniond q_VB = state.T_VB.q() * turn;  // moved
  const Eigen::Matrix3d R_VB = q_VB.toRotationMatrix(), R_turn = turn.toRotationMatrix();
  const Eigen::Matrix3d R_CB = q_BC.toRotationMatrix().transpose();
  const Eigen::Vector3d p_BC = values.T_BC.p();
  jacobian->of_body.setZero();
  jacobian->of_body.topLeftCorner<3, 3>().setIdentity();
  jacobian->of_body.topRightCorner<3, 3>() = -R_VB * so3::Hat(p_BC) * R_turn.transpose();
  jacobian->of_body.bottomRightCorner<3, 3>() = R_CB * R_turn.transpose();
  jacobian->of_calibration.setZero(6, unknowns.size());
  if (unknowns.time_offset) {
    jacobian->of_calibration.col(0) << image.v_V + R_VB * image.omega_B.cross(p_BC),
        R_CB * image.omega_B;
  }
  if (unknowns.T_BC) {
    jacobian->of_calibration.topRightCorner<3, 6>().leftCols<3>() = R_VB;
    jacobian->of_calibration.bottomRightCorner<3, 3>().setIdentity();
  }
  return {q_VB * q_BC, state.T_VB.p() + image.v_V * dt + R_VB * p_BC};
}

}  // namespace

void WindowNormal::Reset(int size) {
  H.setZero(size, size);
  g.setZero(size);
  eliminated.setZero(size);
  cost = 0.0;
}

void WindowFrames::MoveTo(const WindowValues& values, const std::vector<WindowImage>& images,
                          const WindowUnknowns& unknowns) {
  frames.clear();
  cameras.resize(values.states.size());
  for (std::size_t i = 0; i < values.states.size(); ++i) {
    frames.push_back(FrameAt(CameraAt(values.states[i], images[i], values, unknowns, &cameras[i])));
    frames.push_back(FrameAt(values.states[i].T_VW));
  }
}

void WindowFrames::StepsOf(const Eigen::VectorXd& step, const WindowLayout& layout,
                           Eigen::VectorXd* of_frames) const {
  of_frames->resize(static_cast<Eigen::Index>(12 * cameras.size()));
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto first = static_cast<Eigen::Index>(12 * i);
    const auto& [of_body, of_calibration] = cameras[i];
    of_frames->segment<6>(first) =
        of_body * step.segment<6>(layout.head[i]) +
        of_calibration * step.segment(layout.cameras, of_calibration.cols());
    of_frames->segment<6>(first + 6) = step.segment<6>(layout.head[i] + 6);
  }
}

void FrameSystem::Reset(int frames) {
  frames_ = frames;
  H_.assign(static_cast<std::size_t>(frames * frames), Block::Zero());
  g_.assign(static_cast<std::size_t>(frames), Segment::Zero());
  eliminated_.assign(static_cast<std::size_t>(frames), Segment::Zero());
}

void FrameSystem::AddTo(const WindowFrames& frames, const WindowLayout& layout,
                        WindowNormal* normal) const {
  const auto of_body = [&](int frame) -> const Block& {
    return frames.cameras[static_cast<std::size_t>(frame / 2)].of_body;
  };
  for (int a = 0; a < frames_; ++a) {
    const int row = FirstRow(a, layout);
    const Segment& g = g_[static_cast<std::size_t>(a)];
    const Segment& eliminated = eliminated_[static_cast<std::size_t>(a)];
    if (IsCamera(a)) {
      normal->g.segment<6>(row) += of_body(a).transpose() * g;
      normal->eliminated.segment<6>(row) += of_body(a).cwiseAbs2().transpose() * eliminated;
    } else {
      normal->g.segment<6>(row) += g;
      normal->eliminated.segment<6>(row) += eliminated;
    }
    for (int b = a; b < frames_; ++b) {
      const int column = FirstRow(b, layout);
      Block block = H_[Index(a, b)];
      if (IsCamera(a)) block = of_body(a).transpose() * block.eval();
      if (IsCamera(b)) block = block.eval() * of_body(b);
      normal->H.block<6, 6>(row, column) += block;
      if (a != b) normal->H.block<6, 6>(column, row) += block.transpose();
    }
  }
  AddCalibration(frames, layout, normal);
}

void FrameSystem::AddCalibration(const WindowFrames& frames, const WindowLayout& layout,
                                 WindowNormal* normal) const {
  const Eigen::Index size = layout.size - layout.cameras, place = layout.cameras;
  if (size == 0) return;
  for (int a = 0; a < frames_; ++a) {
    const auto& [of_body, of_calibration] = frames.cameras[static_cast<std::size_t>(a / 2)];
    Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 7> sum(6, size);
    sum.setZero();
    for (int b = 0; b < frames_; b += 2) {
      const auto& other = frames.cameras[static_cast<std::size_t>(b / 2)].of_calibration;
      if (a <= b) {
        sum.noalias() += H_[Index(a, b)].lazyProduct(other);
      } else {
        sum.noalias() += H_[Index(b, a)].transpose().lazyProduct(other);
      }
    }
    if (IsCamera(a)) {
      normal->H.block(place, place, size, size) += of_calibration.transpose() * sum;
      normal->g.segment(place, size) +=
          of_calibration.transpose() * g_[static_cast<std::size_t>(a)];
      normal->eliminated.segment(place, size) +=
          of_calibration.cwiseAbs2().transpose() * eliminated_[static_cast<std::size_t>(a)];
      sum = (of_body.transpose() * sum).eval();
    }
    normal->H.block(FirstRow(a, layout), place, 6, size) += sum;
    normal->H.block(place, FirstRow(a, layout), size, 6) += sum.transpose();
  }
}

}  // namespace highwall
