#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/internal/landmark_normal.h>

#include "inertial/window_frames.h"

namespace highwall {

// Huber loss: rho(s) = scale s up to s = width^2.
struct WindowLoss {
  double width = std::numeric_limits<double>::infinity();
  double scale = 1.0;

  struct Value {
    double rho, weight;  // and its derivative
  };
  Value At(double s) const;
};

// Observation of a landmark from a frame. `inside`: it is in its domain at the start of a solve.
struct WindowPointView {
  int frame = 0;
  WindowLoss loss{};
  // Of the camera; on the map r = A p_F + b.
  ProjectionRows<3> rows;
  bool inside = true;
};
struct WindowLineView {
  int frame = 0;
  WindowLoss loss{};
  std::shared_ptr<const ceres::CostFunction> factor;  // of T_VF and the line, up to 4 rows
  bool inside = true;
};

// Landmarks of VisualInertialWindow, in V. Views ascend by frame.
struct WindowPoint {
  static constexpr int kSize = 3, kDim = 3;
  using View = WindowPointView;

  PointId id;
  Eigen::Vector3d value;
  std::vector<View> views;
};
struct WindowLine {
  static constexpr int kSize = 6, kDim = 4;
  using View = WindowLineView;

  LineId id;
  OrthonormalLine value;
  std::vector<View> views;
};

// Eliminates the landmarks one by one from the equations of the frames, in blocks of fixed size and
// without any allocation (variable projection, as LinearSolver::kVariableProjection): at each x of
// the frames they are optimized by a few Gauss-Newton steps of their own.
class WindowLandmarks {
 public:
  // The landmarks at one x, and their feedback to a step: dl = -u - W dx.
  struct Estimates {
    std::vector<double> values, costs, feedback;
    double cost = 0.0;
  };
  // A step of the frames from estimates. retry: an earlier step from them failed.
  struct Step {
    const Estimates& from;
    const Eigen::VectorXd& frames;
    bool retry = false;
  };

  explicit WindowLandmarks(const RgbdProjection& projection) : projection_(projection) {}

  std::vector<WindowPoint>& points() { return points_; }
  std::vector<WindowLine>& lines() { return lines_; }

  // Prepares for the landmarks and views there are.
  void Begin();
  // Adds the equations of the frames. step: null at the beginning, where the landmarks are at their
  // values. Returns false if a landmark cannot be evaluated.
  bool Evaluate(const WindowFrames& frames, const Step* step, Estimates* estimates,
                FrameSystem* system);
  // Takes over the values.
  void SetValues(const Estimates& estimates);
  // Adds the equations of the landmarks that the oldest state observes, and removes them; the other
  // frames then have the indices without that state. Returns false if one cannot be evaluated.
  bool Leave(const WindowFrames& frames, FrameSystem* system);

 private:
  // Place of a landmark in Estimates.
  struct Place {
    std::size_t value = 0, feedback = 0;
  };
  // Linearized views of a point: J^T W J and J^T W r by its position p_F in the frame.
  struct PointTerm {
    bool active = false;
    Eigen::Matrix3d N;
    Eigen::Vector3d n, p_F;
  };
  struct LineTerm {
    double weight = 0.0;  // 0: outside of its domain
    Eigen::Matrix<double, 4, 6> of_frame;
    Eigen::Matrix<double, 4, 4> of_line;
    Eigen::Vector4d r;
  };
  // H_lx of the landmark at hand, by the frames that observe it.
  template <int kDim>
  struct Couplings {
    std::vector<Eigen::Matrix<double, kDim, 6>> E;
    std::vector<int> frames;
    std::size_t count = 0;
  };

  template <class Landmark>
  bool EvaluateAll(std::vector<Landmark>& landmarks, const Step* step, Estimates* estimates,
                   FrameSystem* system);
  template <class Landmark>
  bool Fit(Landmark& landmark, const Step* step, double* value,
           internal::LandmarkNormal<Landmark::kDim>* normal);
  template <class Landmark>
  bool Descend(Landmark& landmark, double* value, internal::LandmarkNormal<Landmark::kDim>* normal);
  template <class Landmark>
  void Follow(const Landmark& landmark, const Step& step, double* value) const;
  bool Linearize(WindowPoint& point, const double* value, internal::LandmarkNormal<3>* normal);
  bool Linearize(WindowLine& line, const double* value, internal::LandmarkNormal<4>* normal);
  // Adds the frames' part of the views, and collects the couplings.
  void Accumulate(const WindowPoint& point, FrameSystem* system);
  void Accumulate(const WindowLine& line, FrameSystem* system);
  template <class Landmark>
  void Eliminate(const internal::LandmarkNormal<Landmark::kDim>& normal, double* feedback,
                 FrameSystem* system);
  template <class Landmark>
  bool LeaveAll(std::vector<Landmark>* landmarks, FrameSystem* system);
  template <class Landmark>
  Couplings<Landmark::kDim>& CouplingsOf() {
    if constexpr (Landmark::kDim == 3) {
      return point_couplings_;
    } else {
      return line_couplings_;
    }
  }

  RgbdProjection projection_;
  std::vector<WindowPoint> points_;
  std::vector<WindowLine> lines_;
  std::vector<Place> places_;  // points first

  // Of the evaluation at hand.
  const WindowFrames* frames_ = nullptr;
  bool begins_ = false;
  double worth_ = 0.0;     // decrease that justifies a step of a landmark alone
  std::size_t index_ = 0;  // of the landmark in places_
  std::vector<PointTerm> point_terms_;
  std::vector<LineTerm> line_terms_;
  Couplings<3> point_couplings_;
  Couplings<4> line_couplings_;
};

}  // namespace highwall
