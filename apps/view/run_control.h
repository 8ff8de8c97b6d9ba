#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string_view>

namespace highwall::apps {

// What the buttons of the page ask of the run. Thread-safe.
class RunControl {
 public:
  // Applies "pause", "resume", "step", "save" or "stop"; returns false for anything else. A step
  // pauses the run after the next frame.
  bool Apply(std::string_view command);
  bool paused() const { return paused_; }
  // Whether a stop was requested.
  bool stopped() const { return stopped_; }

  enum class Task { kContinue, kSave, kWait };
  // Returns what to do between two frames, until it is to continue. While the run is paused, waits
  // for a short time, and returns kWait if there is nothing to do.
  Task Next();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool save_ = false;  // guarded by the mutex, as steps_
  int steps_ = 0;
  std::atomic<bool> paused_ = false, stopped_ = false;  // changed with the mutex
};

}  // namespace highwall::apps
