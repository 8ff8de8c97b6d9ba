#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>

#include "inertial/inertial_prior.h"
#include "inertial/window_graph.h"
#include "inertial/window_landmarks.h"
#include "inertial/window_problem.h"

namespace highwall {

// Standard deviations of the drift of the map's error at the body, which no number of landmarks
// observes: of position and direction, as a random walk.
struct MapDrift {
  double position = 6e-4;  // [m/sqrt(s)] > 0
  double rotation = 2e-4;  // [rad/sqrt(s)] > 0
};

// Tightly coupled smoother (docs/inertial_odometry.md): point, line and IMU residuals in one
// optimization, in a frame V that no correction of the map moves. A state is pose, velocity, bias
// and T_VW, the current pose of the map's world W: the errors of the map vary along the path.
// Gravity's direction and the time offset are estimated as well, and so is T_BC if it is an unknown
// of the prior.
//
// Landmarks are constrained by the observations of the map's keyframes, and are marginalized with
// the oldest state that observes them, together with all their observations: no observation of an
// image is counted twice. Those of keyframes are counted each time that a landmark is added.
class VisualInertialWindow {
 public:
  // model: of the camera; its T_BC is not used. Returns empty if the prior is not finite, its
  // covariance is not one, or it leaves a direction unobservable. Throws InvalidArgument on bad
  // options.
  static std::optional<VisualInertialWindow> Make(const ImuCalibration& calibration,
                                                  const MeasurementModel& model,
                                                  const InertialOptions& options,
                                                  const InertialPrior& prior,
                                                  const MapDrift& drift = {});

  // Input of a new state.
  struct Step {
    const ImuPreintegration* imu = nullptr;  // from the newest state; its end is the new stamp
    double weight = 1.0;                     // of the IMU factor
    const SeenLandmarks* seen = nullptr;  // of the image, in the map's world M; null: the IMU alone
    Pose T_WM{};                          // pose of M in W
    double time_offset = 0.0;             // [s] from the image's stamp to the new one
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s] at the end, bias removed
    bool stationary = false;                            // the body does not move
  };
  // Returns false if the smoother rejected the step, leaves a direction of the new state
  // unobservable, or was stopped, which happens after the current iteration: Prior() is then that
  // of the state before, or invalid, and no further step may be added. reason: if not null, output
  // of why it returns false, one line.
  bool Add(const Step& step, const std::stop_token& stop = {}, std::string* reason = nullptr);

  // In W.
  const InertialEstimate& newest() const { return newest_; }
  UnitDirection gravity_W() const { return gravity_W_; }
  double time_offset() const { return time_offset_; }
  // Returns the prior of a window that continues from this one.
  InertialPrior Prior() const;
  // For inspection: the newest state in V, with T_VW, and the covariance of it and of the
  // calibrations, [pose, velocity, bias, gravity, t_d, T_BC if it is an unknown, T_VW].
  const WindowState& newest_V() const { return graph_.values.states.back(); }
  const Eigen::MatrixXd& covariance_V() const { return covariance_V_; }

 private:
  // prior: finite. The window is to be used only once Begin() has returned true.
  VisualInertialWindow(const ImuCalibration& calibration, const MeasurementModel& model,
                       const InertialOptions& options, const InertialPrior& prior,
                       const MapDrift& drift);
  bool Begin(const InertialPrior& prior);
  // Returns the reason why the step is rejected; empty if it is not.
  std::string TryAdd(const Step& step, const std::stop_token& stop);
  bool SetPrior(const InertialPrior& prior);
  // Adds a state that the readings predict, with their factors.
  void AddState(const InertialEstimate& predicted_V, const Step& step);
  WindowLoss LossOf(const SeenLandmarks& seen) const;
  // Adds the observations of one kind by the newest state. most: maximum number of landmarks.
  template <class Landmark>
  void Observe(const Step& step, int most);
  // Adds the observations of a landmark by keyframes.
  void AddMapViews(const Step& step, const SeenLandmark<MapPoint>& seen, WindowPoint* point) const;
  void AddMapViews(const Step& step, const SeenLandmark<MapLine>& seen, WindowLine* line) const;
  WindowPointView ViewOf(const SeenLandmark<MapPoint>& seen) const;
  WindowLineView ViewOf(const SeenLandmark<MapLine>& seen) const;
  // Marginalizes the oldest state if there are too many. Returns as TryAdd().
  std::string Shrink();
  void ReadNewest(Stamp stamp);
  void ReadCovariance(const Eigen::MatrixXd& covariance);

  MeasurementModel model_;
  InertialOptions options_;
  MapDrift drift_;
  std::unique_ptr<std::atomic<bool>> stopped_;  // polled by the solver
  WindowGraph graph_;
  WindowLandmarks landmarks_;
  std::unique_ptr<WindowProblem> problem_;
  FrameSystem leaving_;  // scratch memory
  WindowNormal marginal_;
  InertialEstimate newest_V_, newest_;  // in V, in W
  UnitDirection gravity_W_;
  double time_offset_;
  std::optional<Pose> T_BC_;  // if it is an unknown
  Eigen::MatrixXd covariance_V_;
  Eigen::MatrixXd calibration_covariance_;  // as that of InertialPrior
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling_;
};

}  // namespace highwall
