#include "commands/slam_session.h"

#include <signal.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "cli/commands.h"
#include "cli/progress.h"
#include "commands/run_summary.h"
#include "files/json_text.h"
#include "report/html_report.h"
#include "run/depth_camera.h"
#include "run/loss_advice.h"
#include "run/output_checks.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

// Returns the live view of a run and prints its address; null without --view. signals: outlives it.
std::unique_ptr<LiveView> OpenView(const std::string& command, const SlamArguments& arguments,
                                   const RgbdSensor& sensor, const SlamRunOptions& options,
                                   const StopSignals& signals) {
  if (arguments.view.empty()) return nullptr;
  DenseMapOptions shown = options.map;
  LimitToRange(sensor, &shown);
  LiveViewOptions view{.address = arguments.view_address,
                       .port = std::stoi(arguments.view),
                       .title = ToUtf8(arguments.out),
                       .min_depth = shown.cloud.min_depth,
                       .max_depth = shown.cloud.max_depth,
                       .save_to = {},
                       .interrupted = [&signals] { return signals.caught() != 0; }};
  for (const std::filesystem::path& path : {options.keep_map, options.save_map}) {
    if (!path.empty()) view.save_to.push_back(path);
  }
  auto opened = std::make_unique<LiveView>(sensor, std::move(view));
  fmt::print(stderr, "highwall {}: the run can be seen at {}\n", command, opened->url());
  return opened;
}

// Writes report.html if it is requested, from the current content of the folder, and shows it to
// the clients of the view; returns false if it could not be written.
bool ShowReport(const std::string& command, const SlamArguments& arguments, LiveView* view) {
  constexpr std::chrono::seconds kReportTimeout(10);  // for clients to fetch it
  const bool watched = view != nullptr && view->clients() > 0;
  if (!arguments.report && !watched) return true;
  const std::filesystem::path folder = arguments.out;
  std::string page;
  try {
    page = HtmlReport(std::span(&folder, 1));
    if (arguments.report) WriteHtml(folder / kReportPage, page);
  } catch (const std::exception& error) {
    fmt::print(stderr, "highwall {}: {}\n", command, OneLine(error.what()));
    return !arguments.report;
  }
  if (arguments.report && !HasView3d()) {
    fmt::print(stderr, "highwall {}: warning: report.html has no 3-D view: {}\n", command,
               kNoView3d);
  }
  if (watched) view->End(std::move(page), kReportTimeout);
  return true;
}

// The files of the run that made the map are deleted when another run uses its folder.
void RequireMapElsewhere(const SlamArguments& arguments) {
  namespace fs = std::filesystem;
  if (arguments.overwrite || arguments.load_map.empty()) return;
  std::error_code error;
  const fs::path out = arguments.out, map = fs::absolute(arguments.load_map, error);
  const auto is_in_out = [&](const fs::path& file) {
    return fs::equivalent(file.parent_path(), out, error);
  };
  if (!is_in_out(map) && !is_in_out(fs::canonical(map, error)) &&
      !fs::equivalent(map, out / kMapFile, error)) {
    return;
  }
  throw IoError(arguments.load_map,
                "is in the folder of --out, where this run would replace the one that made the "
                "map: choose another --out, or give --overwrite");
}

// Checks what the run will write before it begins, and returns the folder of the results.
const std::string& CheckedOutput(const SlamArguments& arguments) {
  RequireRunFolder(arguments.out, arguments.overwrite);
  RequireMapElsewhere(arguments);
  if (!arguments.save_map.empty()) RequireFile(arguments.save_map);
  if (!arguments.trace.empty()) RequireFile(arguments.trace);
  return arguments.out;
}

}  // namespace

SlamSession::SlamSession(std::string command, const SlamArguments& arguments)
    : command_(std::move(command)),
      arguments_(arguments),
      lock_(CheckedOutput(arguments)),
      output_(arguments.out, arguments.save_map, arguments.load_map) {
  if (arguments.covariances) output_.KeepCovariances();
}

void SlamSession::Begin(const RgbdSensor& sensor, SlamRunOptions* options) {
  if (!arguments_.localize) options->keep_map = std::filesystem::path(arguments_.out) / kMapFile;
  signals_.emplace();
  view_ = OpenView(command_, arguments_, sensor, *options, *signals_);
  options->observer = view_.get();
  options->stop = [this] { return IsStopRequested(); };
}

bool SlamSession::IsStopRequested() const {
  return (signals_ && signals_->caught() != 0) || (view_ && view_->stopped());
}

SlamRun SlamSession::Track(const std::function<SlamRun(const RunCallbacks& callbacks)>& run) {
  Progress progress("tracking");
  std::optional<bool> is_cut;  // when the last frame was tracked
  SlamRun result = run(
      {.on_frame =
           [&](const FrameResult& frame, const RgbdImage&, std::size_t done, std::size_t total) {
             output_.Follow(frame);
             progress.Update(done, total);
           },
       .on_tracked =
           [&](const SlamRun& tracked) {
             is_cut = IsStopRequested();
             progress.Begin("finishing the maps");
             if (view_) view_->Begin("finishing the maps");
             output_.WriteTrajectories(tracked);
           },
       .on_finding =
           [&](const SensorFinding& finding) {
             progress.Print("highwall " + command_ + ": warning: " + Line(finding));
           }});
  const bool has_end = !result.is_of_camera;  // a recording may end as the request comes
  if (has_end ? result.left > 0 : is_cut.value_or(IsStopRequested())) SetStopped(result);
  return result;
}

void SlamSession::SetStopped(const SlamRun& run) {
  stopped_.emplace();
  if (const int signal = signals_->caught(); signal != 0) {
    stopped_->signal = signal;
    stopped_->by = SignalName(signal);
  }
  stopped_->done = run.frames + run.skipped + run.dropped;
  stopped_->frames = stopped_->done + run.left;
  stopped_->is_of_camera = run.is_of_camera;
}

void SlamSession::PrintStopped(const char* then) const {
  const std::string of = stopped_->is_of_camera ? "" : fmt::format("of {} ", stopped_->frames);
  fmt::print(stderr, "highwall {}: stopped by {} after {} {}frames: {}\n", command_, stopped_->by,
             stopped_->done, of, then);
}

std::optional<int> SlamSession::EndWithoutPose(const SlamRun& run,
                                               const std::string& source) const {
  if (!run.largest.trajectory.empty()) return std::nullopt;
  if (stopped_) {
    PrintStopped("no frame had a pose, and nothing is written");
    return ExitCodeOf(stopped_->signal);
  }
  if (run.is_of_camera && !run.failures.empty()) throw std::runtime_error(run.failures.front());
  if (!arguments_.load_map.empty()) {
    throw IoError(arguments_.load_map, "no frame was recognized in this map");
  }
  const std::string advice = LossAdvice(run.loss_reasons, run.lost.size());
  throw IoError(source,
                "no frame could be tracked: too little texture or depth to start a map (see "
                "highwall info)" +
                    (advice.empty() ? "" : "; " + advice));
}

int SlamSession::Write(const SlamRun& run, nlohmann::json report, bool has_truth) {
  if (stopped_) {
    report["stopped"] = {{"signal", SignalName(stopped_->signal)},
                         {"frames_done", stopped_->done},
                         {"frames", stopped_->frames}};
  }
  {
    const Progress progress("writing the results");
    report = output_.WriteRest(run, report);
  }
  if (arguments_.json) {
    fmt::print("{}\n", JsonText(report));
  } else {
    PrintSummary(run, arguments_, has_truth, report["peak_memory_mib"]);
  }
  for (const std::string& failure : output_.failures()) {
    fmt::print(stderr, "highwall {}: {}\n", command_, OneLine(failure));
  }
  const bool has_page = ShowReport(command_, arguments_, view_.get());
  if (stopped_) {
    PrintStopped("the results are those of these frames");
    return ExitCodeOf(stopped_->signal);
  }
  const bool is_strict_failure = arguments_.strict && run.verdict.trust() != Trust::kConsistent;
  return output_.failures().empty() && has_page && !is_strict_failure ? kExitOk : kExitFailed;
}

}  // namespace highwall::apps
