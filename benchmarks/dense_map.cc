// Dense map of a sequence with ground-truth poses: cost of a keyframe, cost and correctness of a
// correction after a loop, and size of cloud and octree.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/mapping/dense_cloud.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/keyframe_octree.h>
#include <highwall/mapping/point_cloud_io.h>

#include "bench_main.h"
#include "run/config.h"
#include "run/posed_frames.h"
#include "same_leaves.h"
#include "timing.h"

namespace highwall {
namespace {

struct Arguments {
  std::string dataset, config;
  double resolution = 0.05;        // [m]
  double voxel = 0.01;             // [m]
  double max_range = kDenseRange;  // [m]
  std::size_t keyframes = 200;
};

struct Keyframe {
  std::vector<ColoredPoint> cloud_C;
  std::vector<Eigen::Vector3f> points_C;
  Pose T_WC;
};

struct Maps {
  explicit Maps(const Arguments& arguments)
      : octree({.resolution = arguments.resolution, .max_range = arguments.max_range}),
        cloud({.voxel_size = arguments.voxel}) {}

  void Add(std::size_t i, const Keyframe& keyframe, const Pose& T_WC) {
    const auto id = static_cast<std::int64_t>(i);
    octree.SetKeyframe(id, keyframe.points_C, T_WC);
    cloud.SetKeyframe(id, keyframe.cloud_C);
    cloud.SetPose(id, T_WC);
  }

  KeyframeOctree octree;
  DenseCloud cloud;
};

// Applies a loop correction to a drifted trajectory: none at its end, largest at its beginning.
Pose Corrected(const Pose& T_WC, double share) {
  Eigen::Matrix<double, 6, 1> step;
  step << 0.15, -0.1, 0.05, 0.02, -0.03, 0.01;
  return T_WC.Plus(share * step);
}

// Reads the keyframes and adds each to the maps; returns the sorted times [s].
std::vector<double> AddKeyframes(const Arguments& arguments, std::vector<Keyframe>& keyframes,
                                 Maps& maps) {
  const apps::ResolvedConfig config = apps::ResolveConfig(arguments.config, arguments.dataset);
  const RgbdSensor& sensor = config.config.sensor;
  const std::unique_ptr<const Dataset> opened = OpenDataset(arguments.dataset, sensor);
  const Dataset& dataset = *opened;
  if (dataset.groundtruth() == nullptr) throw IoError(arguments.dataset, "has no ground truth");
  const std::size_t every = std::max<std::size_t>(1, dataset.size() / arguments.keyframes);
  const DepthUnprojector unprojector(sensor.camera);
  const KeyframeCloudOptions cloud_options{.max_depth = arguments.max_range,
                                           .voxel_size = arguments.voxel};
  std::vector<double> seconds;
  for (const apps::PosedFrame& frame : apps::PosedFrames(dataset, *dataset.groundtruth(), every)) {
    const auto image = dataset.Load(frame.index);
    if (!image || keyframes.size() == arguments.keyframes) continue;
    Keyframe& keyframe = keyframes.emplace_back();
    keyframe.T_WC = frame.T_WC;
    seconds.push_back(bench::ThreadSeconds([&] {
      keyframe.cloud_C = MakeKeyframeCloud(image->depth, image->bgr, unprojector, cloud_options);
      for (const ColoredPoint& point : keyframe.cloud_C) keyframe.points_C.push_back(point.p);
      maps.Add(keyframes.size() - 1, keyframe, keyframe.T_WC);
    }));
  }
  if (keyframes.empty()) throw IoError(arguments.dataset, "no frame has a ground-truth pose");
  std::ranges::sort(seconds);
  return seconds;
}

nlohmann::ordered_json Sizes(const Maps& maps) {
  const auto folder = std::filesystem::temp_directory_path();
  const auto ply = folder / "highwall_bench_dense.ply", bt = folder / "highwall_bench_dense.bt";
  WritePly(ply, maps.cloud.Merged());
  maps.octree.map().WriteBinary(bt);
  const double cloud_mb = static_cast<double>(std::filesystem::file_size(ply)) / 1e6;
  const double octree_mb = static_cast<double>(std::filesystem::file_size(bt)) / 1e6;
  std::filesystem::remove(ply);
  std::filesystem::remove(bt);
  return {{"stored_scans_mb", static_cast<double>(maps.octree.ScanBytes()) / 1e6},
          {"stored_cloud_mb", static_cast<double>(maps.cloud.MemoryBytes()) / 1e6},
          {"cloud_file_mb", cloud_mb},
          {"octree_file_mb", octree_mb},
          {"cloud_over_octree", cloud_mb / octree_mb}};
}

nlohmann::ordered_json Correct(const Arguments& arguments, const std::vector<Keyframe>& keyframes,
                               Maps& maps) {
  Maps fresh(arguments);
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i);
    const Pose& T_WC = keyframes[i].T_WC;
    const double share = 1.0 - static_cast<double>(i) / static_cast<double>(keyframes.size());
    const Pose target = Corrected(T_WC, share);
    maps.octree.SetPose(id, target);
    maps.cloud.SetPose(id, target);
    // A pose that changed too little is kept, as in the maps above.
    const Pose moved = T_WC.Inverse() * target;
    const bool stays = moved.p().norm() <= 0.01 && moved.Angle() <= 0.5 * 0.01745329;
    fresh.octree.SetKeyframe(id, keyframes[i].points_C, stays ? T_WC : target);
  }
  const double octree_seconds = bench::ThreadSeconds([&] { maps.octree.Rebuild(); });
  const double cloud_seconds = bench::ThreadSeconds([&] { maps.cloud.Rebuild(); });
  return {
      {"correction_s", octree_seconds + cloud_seconds},
      {"correction_octree_s", octree_seconds},
      {"correction_cloud_s", cloud_seconds},
      {"octree_equals_one_from_scratch", bench::SameLeaves(maps.octree.map(), fresh.octree.map())}};
}

nlohmann::ordered_json Run(const Arguments& arguments) {
  Maps maps(arguments);
  std::vector<Keyframe> keyframes;
  const std::vector<double> seconds = AddKeyframes(arguments, keyframes, maps);
  nlohmann::ordered_json report = {{"keyframes", keyframes.size()},
                                   {"resolution_m", arguments.resolution},
                                   {"keyframe_ms_median", 1e3 * seconds[seconds.size() / 2]},
                                   {"keyframe_ms_worst", 1e3 * seconds.back()}};
  report.update(Sizes(maps));
  report.update(Correct(arguments, keyframes, maps));
  return report;
}

}  // namespace
}  // namespace highwall

int main(int argc, char** argv) {
  CLI::App app(
      "Cost, correction and size of the dense map of a TUM RGB-D sequence.\nExample: "
      "highwall_bench_dense --dataset fr1_xyz --config tum1 --keyframes 200",
      "highwall_bench_dense");
  highwall::Arguments arguments;
  bool json = false;
  app.add_option("--dataset", arguments.dataset, "Folder with groundtruth.txt")->required();
  app.add_option("--config", arguments.config, "Calibration, as in highwall slam");
  app.add_option("--keyframes", arguments.keyframes, "At most so many, evenly spread")
      ->check(CLI::PositiveNumber);
  app.add_option("--resolution", arguments.resolution, "Of the octree [m]")
      ->check(CLI::PositiveNumber);
  app.add_option("--voxel", arguments.voxel, "Of the cloud [m]")->check(CLI::PositiveNumber);
  app.add_option("--max-range", arguments.max_range, "[m]")->check(CLI::PositiveNumber);
  app.add_flag("--json", json, "One JSON object on standard output");
  return highwall::bench::RunBench(
      app, argc, argv, [&] { highwall::bench::PrintFigures(highwall::Run(arguments), json, 32); });
}
