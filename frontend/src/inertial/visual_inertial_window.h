#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
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

#include "inertial/inertial_prior.h"
#include "map/seen_landmarks.h"

namespace highwall {

// The tightly coupled window (docs/inertial_odometry.md): point, line and IMU residuals in one
// optimization, in a frame V that no correction of the map moves. A state is pose, velocity, bias
// and T_VW, where the map with its world W lies then: what the map gets wrong changes along the
// way. Gravity's direction and the time offset are estimated along, and T_BC where the prior has it
// as an unknown.
//
// Landmarks are tied to the map by what its keyframes saw of them, and go into the prior with the
// oldest state that sees them, with all that saw them: no observation of an image is counted twice.
// Those of keyframes are, each time that a landmark begins.
class VisualInertialWindow {
 public:
  // model: of the camera; its T_BC is not used. Throws InvalidArgument where the prior cannot be
  // used.
  VisualInertialWindow(const ImuCalibration& calibration, const MeasurementModel& model,
                       const InertialOptions& options, const InertialPrior& prior);

  // What joins the window with a state.
  struct Step {
    const ImuPreintegration* imu = nullptr;  // from the newest state; its end is the new stamp
    double weight = 1.0;                     // of the IMU factor
    const SeenLandmarks* seen = nullptr;  // of the image, in the map's world M; null: the IMU alone
    Pose T_WM{};                          // where that lies in W
    double time_offset = 0.0;             // [s] by which the image's stamp was taken to it
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();  // [rad/s] at the end, bias taken off
    bool stationary = false;                            // the body does not move
  };
  // False where the smoother refused the step, or leaves the new state open: Prior() is that of the
  // state before, or of no use. No step is to be added then. So it is where it was asked to stop,
  // which it does after the iteration that runs.
  bool Add(const Step& step, const std::stop_token& stop = {});

  // In W.
  const InertialEstimate& newest() const { return newest_; }
  UnitDirection gravity_W() const { return gravity_W_; }
  double time_offset() const { return smoother_.Value(time_offset_); }
  // Where a window that followed on this one would start.
  InertialPrior Prior() const;
  // To look into: what it is made of. States of a stamp are pose, velocity, bias, T_VW.
  const SlidingWindowSmoother& smoother() const { return smoother_; }

 private:
  struct State {
    Variable<Pose> pose;  // T_VB
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
    Variable<Pose> T_VW;
  };
  // Of one image: what it sees of the map, and from where.
  struct Sight {
    const Step& step;
    const State& state;
    std::shared_ptr<ceres::LossFunction> loss;
  };

  State AddState(const InertialEstimate& in_V, const Pose& T_VW);
  void AddPrior(const InertialPrior& prior);
  void Tie(const State& before, const State& after, const Step& step);
  std::shared_ptr<ceres::LossFunction> LossOf(const SeenLandmarks& seen) const;
  template <class Seen, class Landmark>
  void Observe(const Sight& sight, const std::vector<Seen>& seen, int most,
               std::map<decltype(Seen::id), Variable<Landmark>>* known);
  // By what keyframes saw of a landmark.
  void TieToMap(const Sight& sight, const SeenPoint& seen, const Variable<Point>& point);
  void TieToMap(const Sight& sight, const SeenLine& seen, const Variable<OrthonormalLine>& line);
  template <class Seen>
  void AddObservation(const Sight& sight, const Seen& seen, const VariableId& landmark);
  void ReadNewest(Stamp stamp);
  // Of the newest state, of what the window's covariance is read.
  std::vector<VariableId> Told() const;
  void ReadCovariance(const Eigen::MatrixXd& of_told);

  MeasurementModel model_;
  InertialOptions options_;
  std::unique_ptr<std::atomic<bool>> stopped_;  // which the smoother looks at
  SlidingWindowSmoother smoother_;
  Variable<UnitDirection> gravity_;  // in V
  Variable<double> time_offset_;
  std::optional<Variable<Pose>> T_BC_;  // where it is an unknown
  State last_;
  std::map<PointId, Variable<Point>> points_;
  std::map<LineId, Variable<OrthonormalLine>> lines_;
  std::shared_ptr<ceres::LossFunction> map_loss_;  // of what keyframes saw
  InertialEstimate newest_V_, newest_;             // in V, in W
  UnitDirection gravity_W_;
  Eigen::MatrixXd calibration_covariance_;  // as of InertialPrior
  Eigen::Matrix<double, 15, Eigen::Dynamic> coupling_;
};

}  // namespace highwall
