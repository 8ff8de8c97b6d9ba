#include "ros/node.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "cli/commands.h"
#include "cli/watch.h"
#include "run/config.h"
#include "run/folder_lock.h"
#include "run/output_checks.h"
#include "run/run_output.h"
#include "run/run_report.h"
#include "run/settings.h"
#include "run/slam_run.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPoll(20);
constexpr double kTfWait = 10.0;  // [s]

void Print(const std::string& line) {
  fmt::print(stderr, "highwall_ros: {}\n", OneLine(line));
}

// Returns the folder of a run, counted from 1.
fs::path FolderOf(const NodeOptions& options, int run) {
  return run == 1 ? options.slam.out : options.slam.out + "_" + std::to_string(run);
}

// Returns the calibration of a file or a preset, else that of the camera's messages.
ResolvedConfig ConfigOf(const NodeOptions& options, const CameraInfo& info) {
  if (options.slam.config.empty()) {
    return {{.sensor = FindSensorProfile(options.sensor)->SensorFor(info.camera)}, "camera_info"};
  }
  const PinholeCamera& sent = info.camera;
  ResolvedConfig resolved = ResolveCameraConfig(options.slam.config, {sent.width, sent.height});
  if (!resolved.note.empty()) Print(resolved.note);
  const PinholeCamera& own = resolved.config.sensor.camera;
  constexpr double kSame = 2.0;  // [px]
  if (own.width != sent.width || own.height != sent.height || std::abs(own.fx - sent.fx) > kSame ||
      std::abs(own.cx - sent.cx) > kSame || std::abs(own.cy - sent.cy) > kSame) {
    Print(fmt::format(
        "warning: camera_info has {} x {} pixels and fx {:.1f}, {} has {} x {} and "
        "{:.1f}, which is used",
        sent.width, sent.height, sent.fx, resolved.origin, own.width, own.height, own.fx));
  }
  return resolved;
}

// One run of the node.
class NodeRun {
 public:
  NodeRun(RosLink& link, NodeInlet& inlet, const NodeOptions& options, const CameraInfo& info,
          const Pose& T_BC)
      : link_(link), inlet_(inlet), options_(options), info_(info), T_BC_(T_BC) {}

  // Returns an ExitCode. ended: whether to end the run.
  int Run(const fs::path& folder, const std::function<bool()>& ended);

 private:
  SlamRunOptions MakeRunOptions(const fs::path& folder, const RunConfig& config) const;
  std::shared_ptr<RunPublisher> MakePublisher(const SlamRunOptions& run, const CameraStream& stream,
                                              const RunConfig& config) const;
  int Write(const SlamRun& run, const SlamRunOptions& options, const ResolvedConfig& resolved,
            RunOutput& output) const;

  RosLink& link_;
  NodeInlet& inlet_;
  const NodeOptions& options_;
  const CameraInfo& info_;
  const Pose T_BC_;
};

SlamRunOptions NodeRun::MakeRunOptions(const fs::path& folder, const RunConfig& config) const {
  SlamRunOptions run = MakeOptions(options_.slam);
  if (!options_.slam.localize) run.keep_map = folder / kMapFile;
  if (!options_.link.imu || options_.slam.localize) return run;  // which works by images alone
  if (config.imu) {
    run.imu = ImuFeed{*config.imu, {}};
  } else if (!options_.slam.imu.empty()) {
    throw InvalidArgument("~imu asks for the IMU, but ~config states no calibration of one");
  }
  return run;
}

std::shared_ptr<RunPublisher> NodeRun::MakePublisher(const SlamRunOptions& run,
                                                     const CameraStream& stream,
                                                     const RunConfig& config) const {
  const std::string& base = options_.link.frames.base;
  return std::make_shared<RunPublisher>(
      link_, stream,
      RunPublisherOptions{.sensor = config.sensor,
                          .T_BC = T_BC_,
                          .base = base.empty() ? info_.frame : base,
                          .period = options_.publish_period,
                          .max_depth = std::min(run.map.cloud.max_depth, config.sensor.max_depth),
                          .map = run.keep_map});
}

int NodeRun::Run(const fs::path& folder, const std::function<bool()>& ended) {
  const SlamArguments& arguments = options_.slam;
  RequireRunFolder(folder, arguments.overwrite);
  if (!arguments.save_map.empty()) RequireFile(arguments.save_map);
  const FolderLock lock(folder);
  const ResolvedConfig resolved = ConfigOf(options_, info_);
  const RgbdSensor& sensor = resolved.config.sensor;
  SlamRunOptions run_options = MakeRunOptions(folder, resolved.config);
  if (arguments.deterministic) cv::setNumThreads(1);
  CameraStreamOptions camera = options_.camera;
  if (run_options.imu) camera.imu_lead = options_.imu_lead;
  const auto stream = std::make_shared<CameraStream>(
      sensor, camera, run_options.imu ? run_options.imu->calibration.time_offset : 0.0);
  const auto publisher = MakePublisher(run_options, *stream, resolved.config);
  run_options.observer = publisher.get();
  RunOutput output(folder, arguments.save_map, arguments.load_map);
  if (arguments.covariances) output.KeepCovariances();
  inlet_.Connect(stream, publisher, arguments.localize);
  link_.Receive();
  const std::string doing = fmt::format(
      "{} with {}, {}, into {}", arguments.localize ? "localizing" : "mapping", resolved.origin,
      run_options.imu ? "with the IMU" : "by images alone", folder.string());
  Print(doing);
  link_.PublishState(0, {.message = "waiting for images: " + doing, .values = {}});
  SlamRun run;
  {
    const Watch watch(ended, [this] { inlet_.Close(); });
    run = RunSlam(
        *stream, sensor, run_options,
        {.on_frame = [&](const FrameResult& result, const RgbdImage&, std::size_t,
                         std::size_t) { output.Follow(result); },
         .on_tracked = [&](const SlamRun& tracked) { output.WriteTrajectories(tracked); },
         .on_finding = [](const SensorFinding& finding) { Print("warning: " + Line(finding)); }});
  }
  inlet_.Connect(nullptr, nullptr, false);
  publisher->Finish(run);
  return Write(run, run_options, resolved, output);
}

int NodeRun::Write(const SlamRun& run, const SlamRunOptions& options,
                   const ResolvedConfig& resolved, RunOutput& output) const {
  Print(fmt::format("{} images, {} lost, {} dropped", run.frames, run.lost.size(), run.dropped));
  if (run.largest.trajectory.empty()) {
    Print("no image had a pose, and nothing is written");
    return run.frames == 0 ? kExitOk : kExitData;
  }
  nlohmann::json report = RunJson(run, options, "", resolved.origin);
  report["max_pair_difference_s"] = options_.camera.max_stamp_difference;
  report["depth_noise"] = ToJson(resolved.config.sensor.depth_noise);
  report["settings"] = ChangedSettings(options.slam);
  report["ros"] = true;
  output.WriteRest(run, report);
  for (const std::string& failure : output.failures()) Print(failure);
  Print("verdict: " + run.verdict.Summary());
  return output.failures().empty() ? kExitOk : kExitFailed;
}

}  // namespace

void NodeInlet::OnCamera(const CameraInfo& info) {
  const std::lock_guard lock(mutex_);
  camera_ = info;
  changed_.notify_all();
}

std::shared_ptr<CameraStream> NodeInlet::stream() {
  const std::lock_guard lock(mutex_);
  return stream_;
}

void NodeInlet::OnColour(Stamp stamp, const cv::Mat& bgr) {
  if (const auto to = stream()) to->AddColour(stamp, bgr);
}

void NodeInlet::OnDepth(Stamp stamp, const cv::Mat& stored) {
  if (const auto to = stream()) to->AddDepth(stamp, stored);
}

void NodeInlet::OnImu(Stamp stamp, const Eigen::Vector3d& gyroscope,
                      const Eigen::Vector3d& accelerometer) {
  if (const auto to = stream()) to->AddImu({stamp, gyroscope, accelerometer});
}

void NodeInlet::OnProblem(const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (problems_.insert(what).second) Print("warning: " + what);
}

Answer NodeInlet::OnSave() {
  std::shared_ptr<RunPublisher> publisher;
  {
    const std::lock_guard lock(mutex_);
    publisher = publisher_;
  }
  return publisher ? publisher->Save() : Answer{false, "nothing runs"};
}

Answer NodeInlet::Ask(const Request& request, const std::string& answer) {
  const std::lock_guard lock(mutex_);
  if (!stream_ || request_) return {false, "no run has begun, or one is ending"};
  request_ = request;
  stream_->Stop();
  return {true, answer};
}

Answer NodeInlet::OnReset() {
  return Ask({}, "the run ends, and a new one begins without its map");
}

Answer NodeInlet::OnLocalize(bool localize) {
  {
    const std::lock_guard lock(mutex_);
    if (localize == localizes_) {
      return {false, localize ? "it only localizes already" : "it maps already"};
    }
  }
  return Ask({.localize = localize, .keep_map = true},
             localize ? "the run ends, and the next one localizes in its map"
                      : "the run ends, and the next one continues the map");
}

std::optional<CameraInfo> NodeInlet::WaitForCamera() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kPoll, [&] { return camera_.has_value(); });
  return camera_;
}

void NodeInlet::Connect(std::shared_ptr<CameraStream> stream,
                        std::shared_ptr<RunPublisher> publisher, bool localizes) {
  const std::lock_guard lock(mutex_);
  stream_ = std::move(stream);
  publisher_ = std::move(publisher);
  localizes_ = localizes;
}

void NodeInlet::Close() {
  const std::lock_guard lock(mutex_);
  if (stream_) stream_->Stop();
}

std::optional<NodeInlet::Request> NodeInlet::TakeRequest() {
  const std::lock_guard lock(mutex_);
  return std::exchange(request_, std::nullopt);
}

int RunNode(RosLink& link, const NodeOptions& options, const StopSignals& signals) {
  NodeInlet inlet;
  link.Start(options.link, inlet);
  const auto ended = [&] { return signals.caught() != 0 || !link.ok(); };
  std::optional<CameraInfo> info;
  while (!info && !ended()) info = inlet.WaitForCamera();
  std::optional<Pose> T_BC;
  while (info && !T_BC && !ended()) {
    T_BC = link.T_BC(info->frame, kTfWait);
    if (!T_BC) Print("no transform from " + info->frame + " to the base frame is published yet");
  }
  int exit_code = kExitOk;
  NodeOptions current = options;
  for (int number = 1; info && !ended(); ++number) {
    const fs::path folder = FolderOf(options, number);
    NodeRun run(link, inlet, current, *info, *T_BC);
    const int code = run.Run(folder, ended);
    exit_code = std::max(exit_code, code);
    const std::optional<NodeInlet::Request> request = inlet.TakeRequest();
    if (!request) break;
    std::error_code error;
    const fs::path map = folder / kMapFile;
    if (!request->keep_map) {
      current.slam.load_map.clear();
    } else if (fs::exists(map, error)) {
      current.slam.load_map = map;
    }
    current.slam.localize = request->localize && !current.slam.load_map.empty();
    if (current.slam.localize) current.slam.save_map.clear();
  }
  link.Stop();
  return exit_code;
}

}  // namespace highwall::apps
