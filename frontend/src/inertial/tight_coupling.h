#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/inertial/visual_pose.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>
#include <highwall/internal/background_job.h>

#include "inertial/inertial_prior.h"
#include "inertial/visual_inertial_window.h"

namespace highwall {

// Runs the tightly coupled smoother next to the loosely coupled one, on a thread of its own: it
// takes an image at the interval TightWindowOptions::interval, and while it works the loosely
// coupled smoother continues. The latter is restarted at each state of the former, from its
// estimate there, with the images since.
class TightCoupling {
 public:
  // An image as the loosely coupled smoother takes it.
  struct Image {
    ImuPreintegration imu;  // since the previous image
    double weight = 1.0;
    std::optional<VisualPose> visual;
    double time_offset = 0.0;  // [s] from its stamp to the end of the readings
    Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();
    bool stationary = false;
  };
  // Estimate at the latest state, and the images since; no prior if the smoother rejected it and
  // has to be restarted.
  struct Result {
    TightUpdate update;
    std::optional<InertialPrior> prior;
    std::vector<Image> since;
  };

  // window: made with the same options. background: on a thread of its own; otherwise Add() waits
  // for it, and every run gives the same result. profile: null: none; must outlive this object.
  TightCoupling(const InertialOptions& options, VisualInertialWindow window, bool background = true,
                RunProfile* profile = nullptr);

  // Adds an image. T_WM: pose of the map. see: returns its map observations, called only if a state
  // is due; empty without images, while readings accumulate.
  void Add(Image image, const Pose& T_WM, const std::function<SeenLandmarks()>& see);
  // Returns the result once, when the work is done; immediately in synchronous mode. Rethrows the
  // exception that ended the work, such as std::bad_alloc; in synchronous mode Add() throws it. The
  // next result is then that of a rejected step.
  std::optional<Result> Take();
  // Cancels the work, whose result will not be taken: it ends after the current iteration, as it
  // does in the destructor. Does not wait.
  void Cancel() {
    if (task_) task_->Cancel();
  }
  bool IsDone() const { return !task_ || task_->IsDone(); }

 private:
  // Input of the smoother, kept while it works.
  struct Work {
    ImuPreintegration imu;
    SeenLandmarks seen;
    VisualInertialWindow::Step step;
    TightUpdate update;
  };

  InertialOptions options_;
  bool background_;
  RunProfile* profile_;
  VisualInertialWindow window_;
  std::optional<ImuPreintegration> pending_;  // the readings since its newest state
  double weighed_ = 0.0;                      // [s] integral of the weight over their time
  std::vector<Image> since_;                  // the images of those readings
  std::unique_ptr<Work> work_;
  bool failed_ = false;                 // an exception ended the work in Add()
  std::optional<BackgroundTask> task_;  // last: it uses window_ and work_
};

}  // namespace highwall
