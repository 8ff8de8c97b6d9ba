#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/internal/background_job.h>

#include "inertial/inertial_prior.h"
#include "inertial/visual_inertial_window.h"
#include "inertial/visual_pose.h"
#include "map/seen_landmarks.h"

namespace highwall {

// The window of landmarks beside the one of poses, on a thread of its own: it takes an image now
// and then, as TightWindowOptions::interval says, and while it works the window of poses goes on.
// That is begun anew at each of its states, from what is known there, with the images since.
class TightCoupling {
 public:
  // An image as the window of poses takes it.
  struct Image {
    ImuPreintegration imu;  // since the image before
    double weight = 1.0;
    std::optional<VisualPose> visual;
    double time_offset = 0.0;  // [s] by which its stamp was taken to that of the readings' end
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();
    bool stationary = false;
  };
  // What is known at the latest state, and the images since; no prior where the window refused it,
  // and is to be begun anew.
  struct Result {
    TightUpdate update;
    std::optional<InertialPrior> prior;
    std::vector<Image> since;
  };

  // As VisualInertialWindow.
  TightCoupling(const ImuCalibration& calibration, const MeasurementModel& model,
                const InertialOptions& options, const InertialPrior& prior);

  // T_WM: where the map lies. see: what the image sees of it, asked for where it is time for a
  // state; empty in the dark, where readings add up.
  void Add(Image image, const Pose& T_WM, const std::function<SeenLandmarks()>& see);
  // Once, when the work is done; in lockstep that is at once.
  std::optional<Result> Take();
  // Nothing is to be taken any more: what it works on ends after the iteration that runs, as it
  // does in the destructor. Does not wait.
  void Cancel() {
    if (task_) task_->Cancel();
  }
  bool IsDone() const { return !task_ || task_->IsDone(); }

 private:
  // What the window is given, kept while it works.
  struct Work {
    ImuPreintegration imu;
    SeenLandmarks seen;
    VisualInertialWindow::Step step;
    TightUpdate update;
  };

  InertialOptions options_;
  VisualInertialWindow window_;
  std::optional<ImuPreintegration> pending_;  // the readings since its newest state
  double weighed_ = 0.0;                      // [s] the weight over their time
  std::vector<Image> since_;                  // the images of those
  std::unique_ptr<Work> work_;
  std::optional<BackgroundTask> task_;  // the last: it uses window_ and work_
};

}  // namespace highwall
