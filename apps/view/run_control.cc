#include "view/run_control.h"

#include <chrono>

namespace highwall::apps {
namespace {

constexpr std::chrono::milliseconds kPauseStep(50);

}  // namespace

bool RunControl::Apply(std::string_view command) {
  {
    const std::lock_guard lock(mutex_);
    if (command == "pause") {
      paused_ = true;
    } else if (command == "resume") {
      paused_ = false;
      steps_ = 0;
    } else if (command == "step") {
      steps_ += paused_ ? 1 : 0;
      paused_ = true;
    } else if (command == "save") {
      save_ = true;
    } else if (command == "stop") {
      stopped_ = true;
    } else {
      return false;
    }
  }
  changed_.notify_all();
  return true;
}

RunControl::Task RunControl::Next() {
  std::unique_lock lock(mutex_);
  const auto runs = [this] { return !paused_ || stopped_ || steps_ > 0; };
  changed_.wait_for(lock, kPauseStep, [&] { return save_ || runs(); });
  if (save_) {
    save_ = false;
    return Task::kSave;
  }
  if (!runs()) return Task::kWait;
  if (paused_ && steps_ > 0) --steps_;
  return Task::kContinue;
}

}  // namespace highwall::apps
