#include "inertial/tight_coupling.h"

#include <utility>

#include <highwall/internal/stage_timer.h>

namespace highwall {
namespace {

constexpr double kStampJitter = 5e-3;  // [s] by which an image may be early for a state

}  // namespace

TightCoupling::TightCoupling(const InertialOptions& options, VisualInertialWindow window,
                             bool background, RunProfile* profile)
    : options_(options), background_(background), profile_(profile), window_(std::move(window)) {}

void TightCoupling::Add(Image image, const Pose& T_WM, const std::function<SeenLandmarks()>& see) {
  pending_ = pending_ ? pending_->Joined(image.imu) : image.imu;
  weighed_ += image.weight * image.imu.delta().duration;
  const double seconds = pending_->delta().duration;
  if (task_ || !see || seconds < options_.tight.interval - kStampJitter) {
    since_.push_back(std::move(image));
    return;
  }
  work_ = std::make_unique<Work>(Work{*pending_, see(), {}, {}});
  work_->step = {.imu = &work_->imu,
                 .weight = weighed_ / seconds,
                 .seen = &work_->seen,
                 .T_WM = T_WM,
                 .time_offset = image.time_offset,
                 .omega_B = image.omega_B,
                 .stationary = image.stationary};
  pending_.reset();
  weighed_ = 0.0;
  since_.clear();
  failed_ = true;  // unless the following returns
  task_.emplace(
      background_,
      [this](const std::stop_token& stop) {
        const StageTimer timer(profile_, "inertial window", &work_->update.milliseconds);
        work_->update.accepted = window_.Add(work_->step, stop, &work_->update.reason);
      },
      ThreadLabel{"inertial window", profile_});
  failed_ = false;
}

std::optional<TightCoupling::Result> TightCoupling::Take() {
  if (std::exchange(failed_, false)) return Result{work_->update, std::nullopt, {}};
  if (!task_ || !task_->IsDone()) return std::nullopt;
  task_->Wait();
  task_.reset();
  if (!work_->update.accepted) return Result{work_->update, std::nullopt, {}};
  return Result{work_->update, window_.Prior(), since_};
}

}  // namespace highwall
