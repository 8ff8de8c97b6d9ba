// highwall map: cloud, octree, grids and pictures of a dataset with known poses.
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/mapping/color_octree.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/depth_filter.h>
#include <highwall/mapping/height_map.h>
#include <highwall/mapping/octree_size.h>
#include <highwall/mapping/point_cloud_io.h>

#include "cli/commands.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "commands/dataset_report.h"
#include "commands/map_compare.h"
#include "files/json_text.h"
#include "files/trajectory_input.h"
#include "plots/map_pictures.h"
#include "run/depth_camera.h"
#include "run/depth_of_run.h"
#include "run/folder_lock.h"
#include "run/late_colour.h"
#include "run/opened_dataset.h"
#include "run/output_checks.h"
#include "run/posed_frames.h"
#include "run/recording_identity.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

constexpr double kInterval = 1.0 / 3.0;  // [s] between frames that are not keyframes

// Returns at least one.
std::size_t FramesIn(double seconds, const Dataset& dataset) {
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < dataset.size(); ++i) stamps.push_back(dataset.stamp(i));
  return static_cast<std::size_t>(std::max(1L, std::lround(seconds * DescribeStamps(stamps).rate)));
}

struct MapArguments {
  std::string source, dataset, trajectory, config, out;
  double resolution = OctomapBuilderOptions().resolution;  // [m]
  double voxel = KeyframeCloudOptions().voxel_size;        // [m] of the cloud
  double max_range = kDenseRange;                          // [m]
  std::size_t every = 0;                                   // 0: all keyframes, otherwise kInterval
  int threads = 2;
  double memory_limit = 2048.0;               // [MB] of the octree
  std::optional<double> max_pair_difference;  // [s] default: that of the run
  BagTopics topics;                           // likewise
  bool raw = false;
  bool overwrite = false;
  bool json = false;
};

// Sequence of the frames.
class FrameSource {
 public:
  // voxel: [m] of the cloud. raw: use the measured depth. run: source of the poses, if any.
  FrameSource(const Dataset& dataset, const std::vector<PosedFrame>& frames,
              const RgbdSensor& sensor, double voxel, bool raw, const std::filesystem::path& run)
      : dataset_(dataset), frames_(frames), sensor_(sensor), voxel_(voxel), raw_(raw) {
    if (run.empty()) return;
    late_colour_ = ReadLateColour(run / kReportFile);
    if (!raw) depth_of_run_.emplace(run);
  }

  // Calls visit(frame) with filtered depth.
  template <typename Visit>
  void ForEach(const Visit& visit) const {
    DepthFilter filter(DepthCameraOf(sensor_), voxel_);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      std::optional<KeyframeImage> frame = Load(i);
      if (frame && !raw_) frame = filter.Push(std::move(*frame));
      if (frame) visit(*frame);
    }
    if (const auto last = filter.Flush()) visit(*last);
  }
  // Returns up to `count` depth images, evenly spaced.
  std::vector<DepthView> Sample(std::size_t count) const {
    std::vector<DepthView> views;
    for (std::size_t i = 0; i < frames_.size(); i += frames_.size() / count + 1) {
      if (const auto frame = Load(i)) views.push_back({frame->depth, frame->T_WC});
    }
    return views;
  }

 private:
  // Returns an empty result if the frame is unusable.
  std::optional<KeyframeImage> Load(std::size_t i) const {
    auto image = dataset_.Load(frames_[i].index);
    if (!image) return std::nullopt;
    // Depth is that of the pose, and the colour of its time may have come with a later image.
    if (const auto later = ImageOfColour(late_colour_, dataset_, image->stamp)) {
      if (const auto other = dataset_.Load(*later)) image->bgr = other->bgr;
    }
    const cv::Mat depth =
        depth_of_run_ ? depth_of_run_->Correct(*image, sensor_.camera) : image->depth;
    return KeyframeImage{.id = static_cast<std::int64_t>(i),
                         .stamp = image->stamp,
                         .depth = depth,
                         .bgr = image->bgr,
                         .T_WC = frames_[i].T_WC,
                         .noise_factor = image->noise_factor};
  }

  const Dataset& dataset_;
  const std::vector<PosedFrame>& frames_;
  const RgbdSensor& sensor_;
  double voxel_;
  bool raw_;
  std::optional<DepthOfRun> depth_of_run_;
  LateColour late_colour_;
};

// Fails before the computation, rather than being killed by the kernel during it.
void RequireFits(const MapArguments& arguments, const FrameSource& frames,
                 const DepthUnprojector& unprojector, const OctomapBuilderOptions& options) {
  constexpr std::size_t kSamples = 40;
  const double megabytes = PredictOctreeBytes(frames.Sample(kSamples), unprojector, options) / 1e6;
  if (megabytes <= arguments.memory_limit) return;
  throw InvalidArgument(fmt::format(
      "an octree of {} m would take about {:.0f} MB, more than the limit of {:.0f} MB: choose a "
      "coarser --resolution, a shorter --max-range or a higher --memory-limit",
      arguments.resolution, megabytes, arguments.memory_limit));
}

nlohmann::ordered_json Write(const std::filesystem::path& out, const DenseMap& dense,
                             const Trajectory& trajectory, std::size_t frames) {
  const Progress progress("writing the maps");
  RemoveTemporariesOfDeadProcesses(out);
  WritePly(out / "cloud.ply", dense.cloud);
  WritePcd(out / "cloud.pcd", dense.cloud);
  dense.octree.WriteBinary(out / "map.bt");
  dense.octree.Write(out / "map.ot");
  WriteColorOctree(out / "map_color.ot", dense.octree, dense.cloud);
  if (dense.grid.width > 0) WriteOccupancyGrid(out / "grid.yaml", dense.grid);
  const OccupancyGrid drivable = TraversabilityGrid(dense.octree, {.R_GW = dense.R_GW});
  if (drivable.width > 0) WriteOccupancyGrid(out / "traversability.yaml", drivable);
  const HeightMap heights = MakeHeightMap(dense.octree, HeightSource::kTop, dense.R_GW);
  if (heights.width > 0) WritePng(out / "heights.png", HeightImage(heights));
  for (const MapPicture& picture : kMapPictures) {
    WriteMapPicture(out / picture.file, picture, dense, trajectory);
  }

  const auto megabytes = [&](const char* name) {
    return static_cast<double>(std::filesystem::file_size(out / name)) / 1e6;
  };
  const OctreeLeafCount leaves = dense.octree.LeafCount();
  nlohmann::ordered_json json = {
      {"frames", frames},
      {"cloud", {{"points", dense.cloud.size()}, {"file_mb", megabytes("cloud.ply")}}},
      {"octree",
       {{"resolution_m", dense.octree.options().resolution},
        {"occupied_leaves", leaves.occupied},
        {"free_leaves", leaves.free},
        {"memory_mb", static_cast<double>(dense.octree.MemoryBytes()) / 1e6},
        {"file_mb", megabytes("map.bt")}}},
      {"grid", {{"width", dense.grid.width}, {"height", dense.grid.height}}},
      {"cloud_over_octree", megabytes("cloud.ply") / megabytes("map.bt")}};
  if (dense.ground_height) json["grid"]["ground_height_m"] = *dense.ground_height;
  AtomicFile file(out / kMapsReportFile);
  file.stream() << JsonText(json, 2) << '\n';
  file.Commit();
  return json;
}

DenseMapOptions MapOptions(const MapArguments& arguments, const RgbdSensor& sensor) {
  DenseMapOptions options;
  options.cloud.max_depth = options.octree.max_range = arguments.max_range;
  options.cloud.voxel_size = arguments.voxel;
  options.octree.resolution = arguments.resolution;
  options.octree.threads = arguments.threads;
  LimitToRange(sensor, &options);
  return options;
}

// level: z of W points up.
DenseMap Build(const MapArguments& arguments, const FrameSource& frames, std::size_t count,
               bool level, const DepthUnprojector& unprojector, const DenseMapOptions& options,
               Progress& progress) {
  progress.Begin("mapping");
  DenseMap dense;
  dense.octree = OctomapBuilder(options.octree);
  DenseCloud cloud({.voxel_size = arguments.voxel});
  std::vector<Pose> cameras;
  std::size_t done = 0;
  frames.ForEach([&](const KeyframeImage& frame) {
    cloud.SetKeyframe(frame.id,
                      MakeKeyframeCloud(frame.depth, frame.bgr, unprojector, options.cloud));
    cloud.SetPose(frame.id, frame.T_WC);
    dense.octree.Insert(frame.depth, unprojector, frame.T_WC);
    cameras.push_back(frame.T_WC);
    progress.Update(++done, count);
  });
  progress.Begin("cleaning the cloud, making the grid");
  dense.cloud = cloud.TakeMerged();
  if (!arguments.raw) dense.cloud = RemoveOutliers(dense.cloud);
  AddGrid(cameras, level, {}, dense);
  return dense;
}

// Whether the maps belong to the run in the output folder, in the world of its largest map.
bool MapsRunInPlace(const MapArguments& arguments) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::equivalent(arguments.source, arguments.out, error)) return false;
  if (arguments.trajectory.empty()) return true;
  return std::ranges::any_of(
      std::array{kKeyframesFile, kTrajectoryFile, kAdjustedFile}, [&](const char* name) {
        return fs::equivalent(arguments.trajectory, fs::path(arguments.out) / name, error);
      });
}

// Checks the output folder. In the folder of a run, maps of the same run may be replaced.
void RequireMapsFolder(const MapArguments& arguments) {
  using Content = FolderContent;
  const bool in_place = ContentOf(arguments.out) == Content::kRun && MapsRunInPlace(arguments);
  RequireOwnFolder(arguments.out, {Content::kNothing, Content::kMaps, Content::kUnfinished},
                   arguments.overwrite || in_place);
}

// The poses of a run are those of its own recording. One that the user names is believed.
void CheckRecording(const MapArguments& arguments, const MapSource& source,
                    const Dataset& dataset) {
  if (source.run.empty()) return;
  if (arguments.dataset.empty()) return RequireRecordingOfRun(source.dataset, dataset, source.run);
  const std::string difference = DifferenceFromRun(dataset, ReadJson(source.run / kReportFile));
  if (difference.empty()) return;
  PrintWarning("map", source.dataset.string() + " is another recording than that of the run: it " +
                          difference);
}

int RunMap(const MapArguments& arguments) {
  const MapSource source = ResolveSource(arguments.source, arguments.dataset, arguments.trajectory);
  RequireMapsFolder(arguments);
  const FolderLock lock(arguments.out);
  DatasetOptions images = source.images;
  if (arguments.max_pair_difference) images.max_stamp_difference = *arguments.max_pair_difference;
  if (arguments.topics != BagTopics()) images.topics = arguments.topics;
  const OpenedDataset opened = OpenWithConfig(
      arguments.config.empty() ? source.config : arguments.config, source.dataset, images);
  const RgbdSensor& sensor = opened.config.sensor;
  const Dataset& dataset = *opened.images;
  PrintSources("map", opened);
  CheckRecording(arguments, source, dataset);
  for (const std::string& warning : dataset.warnings()) {
    fmt::print(stderr, "highwall map: warning: {}\n", warning);
  }
  const Trajectory trajectory = ReadStampedPoses("map", source.trajectory);
  const std::size_t every = arguments.every > 0 ? arguments.every
                            : source.keyframes  ? 1
                                                : FramesIn(kInterval, dataset);
  const std::vector<PosedFrame> posed = PosedFrames(dataset, trajectory, every);
  if (posed.empty()) throw IoError(source.trajectory, "has no pose at any frame of the dataset");
  const DepthUnprojector unprojector(sensor.camera);
  const FrameSource frames(dataset, posed, sensor, arguments.voxel, arguments.raw, source.run);
  const DenseMapOptions options = MapOptions(arguments, sensor);
  const DenseMap dense = [&] {
    Progress progress("predicting the size of the octree");
    RequireFits(arguments, frames, unprojector, options.octree);
    return Build(arguments, frames, posed.size(), source.level, unprojector, options, progress);
  }();
  for (const Dataset::Problem& problem : dataset.problems()) {
    fmt::print(stderr, "highwall map: skipped frame {}: {}\n", problem.frame, problem.what);
  }
  if (dense.octree.LeafCount().occupied == 0 && !dense.cloud.empty()) {
    throw InvalidArgument(fmt::format(
        "an octree of {} m has no occupied voxel, as all points lie in the voxel of the camera: "
        "choose a finer --resolution",
        arguments.resolution));
  }
  if (dense.octree.LeafCount().occupied == 0) {
    throw IoError(source.dataset,
                  "no frame has depth between 0.3 m and --max-range (see highwall info)");
  }
  const nlohmann::ordered_json report = Write(arguments.out, dense, trajectory, posed.size());
  if (arguments.json) {
    fmt::print("{}\n", JsonText(report));
    return kExitOk;
  }
  fmt::print("frames      {}\n", posed.size());
  fmt::print("cloud       {} points, {:.2f} MB\n", dense.cloud.size(),
             report["cloud"]["file_mb"].get<double>());
  fmt::print("octree      {} nodes at {} m, {:.3f} MB\n", dense.octree.NodeCount(),
             arguments.resolution, report["octree"]["file_mb"].get<double>());
  fmt::print("grid        {} x {} cells\n", dense.grid.width, dense.grid.height);
  fmt::print("results in  {}\n", arguments.out);
  return kExitOk;
}

}  // namespace

void AddMapCommand(CLI::App& app, CommandAction& action) {
  const auto arguments = std::make_shared<MapArguments>();
  CLI::App* command = app.add_subcommand(
      "map", "Cloud, octree, grids and pictures of a run or of a dataset with known poses");
  command->require_subcommand(0, 1);
  command->add_option("source", arguments->source,
                      "Folder of a run (highwall slam --out) or of a dataset");
  command->add_option("--resolution", arguments->resolution, "Edge of the octree's voxels [m]")
      ->check(Between(1e-4, 10.0))
      ->capture_default_str();
  command->add_option("--out", arguments->out, "Folder for the results")->check(NotEmpty());
  command->add_option(
      "--trajectory", arguments->trajectory,
      "Camera poses, as eval reads them [run: keyframes.txt, dataset: groundtruth.txt]");
  command->add_option("--dataset", arguments->dataset, "Where the dataset of a run lies now");
  command->add_option("--config", arguments->config,
                      "Calibration, as in highwall slam [default: that of the run]");
  AddMaxPairDifference(command, &arguments->max_pair_difference);
  AddTopics(command, &arguments->topics);
  command
      ->add_option("--every", arguments->every,
                   "Takes every n-th posed frame [keyframes: 1, else one in a third of a second]")
      ->check(CLI::PositiveNumber);
  command->add_option("--voxel", arguments->voxel, "Edge of the cloud's voxels [m]")
      ->check(Between(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--max-range", arguments->max_range, "Largest depth that is used [m]")
      ->check(Between(0.31, 1000.0))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads that build the octree")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command
      ->add_option("--memory-limit", arguments->memory_limit,
                   "Reject an octree that would need more [MB]")
      ->check(Between(1.0, 1e9))
      ->capture_default_str();
  command->add_flag("--raw", arguments->raw,
                    "Neither smooths depth, compares neighbouring images nor removes outliers");
  command->add_flag("--overwrite", arguments->overwrite, kOverwriteHelp);
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  command->footer(
      "Example:\n  highwall map run --resolution 0.02 --out map\n"
      "  highwall map compare map/cloud.ply mine/surface.ply --seen-by mine \\\n"
      "      --align run/trajectory.txt mine/groundtruth.txt");
  AddMapCompareCommand(*command, action);
  command->callback([command, arguments, &action] {
    if (!command->get_subcommands().empty()) return;
    if (arguments->source.empty()) throw CLI::RequiredError("source");
    if (arguments->out.empty()) throw CLI::RequiredError("--out");
    action = [arguments] { return RunMap(*arguments); };
  });
}

}  // namespace highwall::apps
