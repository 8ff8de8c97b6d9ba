// Octree building over a TUM RGB-D sequence with its ground-truth poses: OctomapBuilder compared
// with octomap::OcTree::insertPointCloud, in seconds of processor time and voxel by voxel.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <octomap/OcTree.h>
#include <CLI/App.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>
#include <highwall/mapping/octomap_builder.h>

#include "bench_main.h"
#include "run/config.h"
#include "same_leaves.h"
#include "support/stock_octree.h"
#include "timing.h"

namespace highwall {
namespace {

constexpr Stamp kMaxStampDifference = 20'000'000;  // [ns]

// Returns "stamp rest" of the lines of a TUM list.
std::map<Stamp, std::string> ReadList(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw IoError(path, "cannot be read");
  std::map<Stamp, std::string> entries;
  std::string line;
  for (std::int64_t number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    const std::size_t space = line.find(' ');
    const auto stamp = ParseStamp(std::string_view(line).substr(0, space));
    if (!stamp || space == std::string::npos) throw IoError(path, number, "expected a stamp");
    entries[*stamp] = line.substr(space + 1);
  }
  return entries;
}

// Returns the ground-truth pose closest in time; empty if there is none within 20 ms.
std::optional<Pose> PoseAt(const std::map<Stamp, std::string>& poses, Stamp stamp) {
  auto nearest = poses.lower_bound(stamp);
  if (nearest == poses.end() ||
      (nearest != poses.begin() && stamp - std::prev(nearest)->first < nearest->first - stamp)) {
    if (nearest == poses.begin()) return std::nullopt;
    --nearest;
  }
  if (std::abs(nearest->first - stamp) > kMaxStampDifference) return std::nullopt;
  TextReader values(nearest->second);
  double block[Pose::kSize];
  for (double& value : block) values >> value;
  if (!values) return std::nullopt;
  return Pose::FromBlock(block);
}

// Returns the share of the leaves of `map` with the same class in `stock`.
double Agreement(const OctomapBuilder& map, const octomap::OcTree& stock) {
  std::size_t same = 0, all = 0;
  map.ForEachLeaf([&](const OctreeLeaf& leaf) {
    const Eigen::Vector3d& p = leaf.center_W;
    const octomap::OcTreeNode* const node = stock.search(p.x(), p.y(), p.z());
    ++all;
    same += node != nullptr && stock.isNodeOccupied(node) == leaf.occupied;
  });
  return all > 0 ? static_cast<double>(same) / static_cast<double>(all) : 1.0;
}

// Returns the processor time of the whole process.
template <typename Work>
double ProcessSeconds(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Scan {
  cv::Mat depth;
  Pose T_WC;
};

// Times [s] of a scan.
struct ScanTimes {
  std::vector<double> wall;
  double processor = 0.0, caller = 0.0;  // sums; caller: the calling thread

  void Insert(const Scan& scan, const DepthUnprojector& unprojector, OctomapBuilder& map) {
    wall.push_back(bench::WallSeconds([&] {
      caller += bench::ThreadSeconds([&] {
        processor += ProcessSeconds([&] { map.Insert(scan.depth, unprojector, scan.T_WC); });
      });
    }));
  }
};

// Returns the mean over the scans of each scan's best time, which excludes the load of other
// processes.
double MeanOfBest(const std::vector<double>& wall, std::size_t scans) {
  double sum = 0.0;
  for (std::size_t scan = 0; scan < scans; ++scan) {
    double best = wall[scan];
    for (std::size_t i = scan; i < wall.size(); i += scans) best = std::min(best, wall[i]);
    sum += best;
  }
  return sum / static_cast<double>(scans);
}

// Builds the map with one thread and with `threads`, alternating by scan, each `rounds` times from
// scratch.
nlohmann::json CompareThreads(const std::vector<Scan>& scans, const PinholeCamera& camera,
                              const OctomapBuilderOptions& options, int threads, int rounds) {
  const DepthUnprojector unprojector(camera);
  OctomapBuilderOptions parallel_options = options;
  parallel_options.threads = threads;
  ScanTimes single_times, parallel_times;
  bool equal = true;
  for (int round = 0; round < rounds; ++round) {
    OctomapBuilder single(options), parallel(parallel_options);
    for (const Scan& scan : scans) {
      single_times.Insert(scan, unprojector, single);
      parallel_times.Insert(scan, unprojector, parallel);
    }
    equal =
        equal && bench::SameLeaves(single, parallel) && single.NodeCount() == parallel.NodeCount();
  }
  const double milliseconds = 1e3 / static_cast<double>(single_times.wall.size());
  const double single_best = MeanOfBest(single_times.wall, scans.size());
  const double parallel_best = MeanOfBest(parallel_times.wall, scans.size());
  return {
      {"count", threads},
      {"equal", equal},
      {"speedup_of_best", single_best / parallel_best},
      {"speedup_of_medians", UpperMedian(single_times.wall) / UpperMedian(parallel_times.wall)},
      {"one_wall_ms_best", 1e3 * single_best},
      {"wall_ms_best", 1e3 * parallel_best},
      {"one_wall_ms_median", 1e3 * UpperMedian(single_times.wall)},
      {"wall_ms_median", 1e3 * UpperMedian(parallel_times.wall)},
      {"one_processor_ms", single_times.processor * milliseconds},
      {"caller_processor_ms", parallel_times.caller * milliseconds},
      {"others_processor_ms", (parallel_times.processor - parallel_times.caller) * milliseconds}};
}

// A way of calling octomap::OcTree::insertPointCloud, with its map.
struct StockMode {
  std::string name;
  bool lazy = false;  // inner nodes are only updated after the last scan
  bool discretize = false;
  octomap::OcTree tree;
  double seconds = 0.0;
};

octomap::Pointcloud WorldCloud(const Scan& scan, const DepthUnprojector& unprojector,
                               double min_depth) {
  const Eigen::Matrix3f R_WC = scan.T_WC.R().cast<float>();
  const Eigen::Vector3f p_WC = scan.T_WC.p().cast<float>();
  octomap::Pointcloud cloud;
  for (int v = 0; v < scan.depth.rows; ++v) {
    for (int u = 0; u < scan.depth.cols; ++u) {
      const float z = scan.depth.at<float>(v, u);
      if (!(z >= static_cast<float>(min_depth))) continue;
      const Eigen::Vector3f p_W = R_WC * unprojector.Unproject(u, v, z) + p_WC;
      cloud.push_back(p_W.x(), p_W.y(), p_W.z());
    }
  }
  return cloud;
}

class Benchmark {
 public:
  Benchmark(const PinholeCamera& camera, const OctomapBuilderOptions& options)
      : unprojector_(camera),
        options_(options),
        map_(options),
        stock_{{{"", false, false, StockTree(options)},
                {"_discretized", false, true, StockTree(options)},
                {"_lazy", true, true, StockTree(options)}}} {}

  // Each map is built separately, as in use, so that none evicts another from the caches.
  void Insert(const std::vector<Scan>& scans) {
    for (const Scan& scan : scans) {
      ours_seconds_ += ProcessSeconds([&] { map_.Insert(scan.depth, unprojector_, scan.T_WC); });
    }
    for (StockMode& mode : stock_) Insert(scans, mode);
    scans_ += static_cast<int>(scans.size());
  }

  // Names by mode of stock: no suffix for its default call, _discretized, and _lazy, which is
  // discretized as well.
  nlohmann::json Report() const {
    const double milliseconds = 1e3 / std::max(1, scans_);
    nlohmann::json report = {{"scans", scans_},
                             {"resolution", options_.resolution},
                             {"scan_ms", ours_seconds_ * milliseconds},
                             {"nodes", map_.NodeCount()},
                             {"memory_bytes", map_.MemoryBytes()}};
    for (const StockMode& mode : stock_) {
      report["speedup" + mode.name] = mode.seconds / ours_seconds_;
      report["agreement" + mode.name] = Agreement(map_, mode.tree);
      report["stock" + mode.name + "_scan_ms"] = mode.seconds * milliseconds;
    }
    const double fastest = std::ranges::min_element(stock_, {}, &StockMode::seconds)->seconds;
    report["speedup_fastest"] = fastest / ours_seconds_;
    report["stock_fastest_scan_ms"] = fastest * milliseconds;
    return report;
  }

 private:
  void Insert(const std::vector<Scan>& scans, StockMode& mode) const {
    for (const Scan& scan : scans) {
      // Not timed: stock octomap is only charged for the insertion.
      const octomap::Pointcloud cloud = WorldCloud(scan, unprojector_, options_.min_depth);
      const Eigen::Vector3f p = scan.T_WC.p().cast<float>();
      const octomap::point3d origin(p.x(), p.y(), p.z());
      mode.seconds += ProcessSeconds([&] {
        mode.tree.insertPointCloud(cloud, origin, options_.max_range, mode.lazy, mode.discretize);
      });
    }
    // Otherwise the map could not be queried above its leaves.
    if (mode.lazy) mode.seconds += ProcessSeconds([&] { mode.tree.updateInnerOccupancy(); });
  }

  DepthUnprojector unprojector_;
  OctomapBuilderOptions options_;
  OctomapBuilder map_;
  std::array<StockMode, 3> stock_;
  double ours_seconds_ = 0.0;
  int scans_ = 0;
};

std::vector<Scan> ReadScans(const std::filesystem::path& dataset, const RgbdSensor& sensor,
                            int stride) {
  const auto images = ReadList(dataset / "depth.txt");
  const auto poses = ReadList(dataset / "groundtruth.txt");
  std::vector<Scan> scans;
  int index = 0;
  for (const auto& [stamp, name] : images) {
    if (index++ % stride != 0) continue;
    const std::optional<Pose> T_WC = PoseAt(poses, stamp);
    if (!T_WC) continue;
    const cv::Mat raw = cv::imread((dataset / name).string(), cv::IMREAD_UNCHANGED);
    if (raw.type() != CV_16UC1) throw IoError(dataset / name, "is not a 16-bit depth image");
    scans.push_back(
        {MetricDepth(raw, sensor.depth_factor, sensor.inverse_depth_offset, sensor.depth_pattern),
         *T_WC});
  }
  if (scans.empty()) throw IoError(dataset, "no depth image has a ground-truth pose");
  return scans;
}

struct Arguments {
  std::string dataset, config;
  OctomapBuilderOptions octree;
  int stride = 8, threads = 2, rounds = 3;
  bool json = false;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--dataset", arguments.dataset, "Folder with depth.txt and groundtruth.txt")
      ->required();
  app.add_option("--config", arguments.config, "Calibration, as in highwall slam");
  app.add_option("--resolution", arguments.octree.resolution, "Voxel size [m]")
      ->check(CLI::PositiveNumber);
  app.add_option("--max-range", arguments.octree.max_range, "[m]")->check(CLI::PositiveNumber);
  app.add_option("--stride", arguments.stride, "Every how many-th depth image")
      ->check(CLI::PositiveNumber);
  app.add_option("--threads", arguments.threads, "Compared with one thread")
      ->check(CLI::Range(1, 256));
  app.add_option("--rounds", arguments.rounds, "Maps of that comparison; 0 leaves it out")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--json", arguments.json, "One JSON object on standard output");
}

nlohmann::json Run(const Arguments& arguments) {
  const apps::ResolvedConfig resolved = apps::ResolveConfig(arguments.config, arguments.dataset);
  const RgbdSensor& sensor = resolved.config.sensor;
  const std::vector<Scan> scans = ReadScans(arguments.dataset, sensor, arguments.stride);
  Benchmark benchmark(sensor.camera, arguments.octree);
  benchmark.Insert(scans);
  nlohmann::json report = benchmark.Report();
  if (arguments.rounds == 0) return report;
  const nlohmann::json comparison =
      CompareThreads(scans, sensor.camera, arguments.octree, arguments.threads, arguments.rounds);
  for (const auto& [key, value] : comparison.items()) report["threads_" + key] = value;
  return report;
}

}  // namespace
}  // namespace highwall

int main(int argc, char** argv) {
  CLI::App app(
      "Octree building against stock octomap over a TUM RGB-D sequence.\nExample: "
      "highwall_bench_octomap --dataset fr1_xyz --config tum1 --resolution 0.05 --json",
      "highwall_bench_octomap");
  highwall::Arguments arguments;
  highwall::AddOptions(app, arguments);
  return highwall::bench::RunBench(app, argc, argv, [&] {
    highwall::bench::PrintFigures(highwall::Run(arguments), arguments.json, 26);
  });
}
