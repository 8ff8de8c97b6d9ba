#pragma once

#include <signal.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "cli/stop_signals.h"
#include "run/folder_lock.h"
#include "run/run_output.h"
#include "run/slam_arguments.h"
#include "run/slam_run.h"
#include "view/live_view.h"

namespace highwall::apps {

// What stopped a run, and its progress. The button of the page counts as Ctrl-C.
struct StoppedRun {
  int signal = SIGINT;
  std::string by = "the page";
  std::size_t done = 0, frames = 0;
  bool is_of_camera = false;
};

// What `highwall slam` and `highwall live` share: a run with its outputs, its live page and its end
// by a signal. Call the functions in their order; all may throw IoError.
class SlamSession {
 public:
  // Checks the outputs and locks the folder of the results. command: "slam" or "live", in messages.
  // arguments: must outlive the session.
  SlamSession(std::string command, const SlamArguments& arguments);

  // Catches signals from now on, opens the live page, and sets what options need for both.
  void Begin(const RgbdSensor& sensor, SlamRunOptions* options);
  // Whether a signal or the page asks for the end. On any thread.
  bool IsStopRequested() const;
  // Calls RunSlam() with the callbacks that it gets; poses are written meanwhile.
  SlamRun Track(const std::function<SlamRun(const RunCallbacks& callbacks)>& run);
  // If no frame has a pose: returns the exit code of a run that was stopped, and throws IoError,
  // which names the source of the images, for any other. Else empty.
  std::optional<int> EndWithoutPose(const SlamRun& run, const std::string& source) const;
  // Writes the results with this run.json, prints them, and returns an ExitCode.
  int Write(const SlamRun& run, nlohmann::json report, bool has_truth);

 private:
  void SetStopped(const SlamRun& run);
  void PrintStopped(const char* then) const;

  const std::string command_;
  const SlamArguments& arguments_;
  const FolderLock lock_;
  RunOutput output_;
  std::optional<StopSignals> signals_;
  std::unique_ptr<LiveView> view_;
  std::optional<StoppedRun> stopped_;
};

}  // namespace highwall::apps
