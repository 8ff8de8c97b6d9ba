#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <ceres/loss_function.h>
#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>

#include "inertial/inertial_prior.h"

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
  double time_offset() const { return smoother_.Value(time_offset_); }
  // Returns the prior of a window that continues from this one.
  InertialPrior Prior() const;
  // For inspection. States of a stamp are pose, velocity, bias, T_VW.
  const SlidingWindowSmoother& smoother() const { return smoother_; }

 private:
  struct State {
    Variable<Pose> pose;  // T_VB
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
    Variable<Pose> T_VW;
  };
  // Observations of an image with its state.
  struct ImageObservation {
    const Step& step;
    const State& state;
    std::shared_ptr<ceres::LossFunction> loss;
  };

  // prior: finite. The window is to be used only once Begin() has returned true.
  VisualInertialWindow(const ImuCalibration& calibration, const MeasurementModel& model,
                       const InertialOptions& options, const InertialPrior& prior,
                       const MapDrift& drift);
  bool Begin(const InertialPrior& prior);
  // Returns the reason why the step is rejected; empty if it is not.
  std::string TryAdd(const Step& step, const std::stop_token& stop);
  State AddState(const InertialEstimate& in_V, const Pose& T_VW);
  bool AddPrior(const InertialPrior& prior);
  void AddImuFactor(const State& before, const State& after, const Step& step);
  std::shared_ptr<ceres::LossFunction> LossOf(const SeenLandmarks& seen) const;
  template <class Landmark>
  using VariableOf = Variable<typename LandmarkTraits<Landmark>::VariableType>;
  template <class Landmark>
  using Variables = std::map<Id<Landmark>, VariableOf<Landmark>>;

  // Adds the observations of one kind. most: maximum number of landmarks of one image.
  template <class Landmark>
  void Observe(const ImageObservation& observation, int most);
  // Adds the observations of a landmark by keyframes.
  void AddMapObservation(const ImageObservation& observation, const SeenLandmark<MapPoint>& seen,
                         const Variable<Point>& point);
  void AddMapObservation(const ImageObservation& observation, const SeenLandmark<MapLine>& seen,
                         const Variable<OrthonormalLine>& line);
  template <class Landmark>
  void AddObservation(const ImageObservation& observation, const SeenLandmark<Landmark>& seen,
                      const VariableId& landmark);
  void ReadNewest(Stamp stamp);
  // Returns the variables, mainly of the newest state, whose covariance is read.
  std::vector<VariableId> QueriedVariables() const;
  void ReadCovariance(const Eigen::MatrixXd& covariance);

  MeasurementModel model_;
  InertialOptions options_;
  MapDrift drift_;
  std::unique_ptr<std::atomic<bool>> stopped_;  // polled by the smoother
  SlidingWindowSmoother smoother_;
  Variable<UnitDirection> gravity_;  // in V
  Variable<double> time_offset_;
  std::optional<Variable<Pose>> T_BC_;  // if it is an unknown
  State last_;
  PerKind<Variables> landmarks_;
  std::shared_ptr<ceres::LossFunction> map_loss_;  // for observations by keyframes
  InertialEstimate newest_V_, newest_;             // in V, in W
  UnitDirection gravity_W_;
  Eigen::MatrixXd calibration_covariance_;  // as that of InertialPrior
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling_;
};

}  // namespace highwall
