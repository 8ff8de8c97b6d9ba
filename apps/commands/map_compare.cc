// highwall map compare: accuracy and completeness of a map against a reference.
#include "commands/map_compare.h"

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/map_comparison.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "files/trajectory_input.h"
#include "run/opened_dataset.h"
#include "run/posed_frames.h"
#include "run/recording_identity.h"

namespace highwall::apps {
namespace {

struct CompareArguments {
  std::string map, reference;
  double spacing = 0.01;  // [m] of the samples of a mesh
  std::string seen_by, trajectory, config;
  std::size_t every = 10;
  double tolerance = 0.05;         // [m]
  double max_range = kDenseRange;  // [m]
  std::vector<std::string> align;  // trajectories of the map and of the reference
  bool json = false;
};

using Points = std::vector<Eigen::Vector3f>;

Points Positions(const std::vector<ColoredPoint>& cloud) {
  Points points;
  for (const ColoredPoint& point : cloud) points.push_back(point.p);
  return points;
}

bool IsOctree(const std::filesystem::path& path) {
  return path.extension() == ".bt" || path.extension() == ".ot";
}

Points ReadPoints(const std::filesystem::path& path) {
  Points points;
  if (IsOctree(path)) {
    points = OccupiedCentres(OctomapBuilder::Read(path));
  } else if (path.extension() == ".pcd") {
    points = Positions(ReadPcd(path));
  } else if (path.extension() == ".ply") {
    points = Positions(ReadPly(path));
  } else {
    throw IoError(path, "the name must end in .ply, .pcd, .bt or .ot");
  }
  if (points.empty()) throw IoError(path, "holds no point");
  return points;
}

ReferenceSurface ReadReference(const std::filesystem::path& path, double spacing) {
  if (path.extension() == ".ply") {
    const TriangleMesh mesh = ReadPlyMesh(path);
    if (!mesh.triangles.empty()) return ReferenceSurface(mesh, spacing);
  }
  return ReferenceSurface(ReadPoints(path));
}

// Applies the transformation that aligns the map's trajectory with the reference's.
void Align(const std::vector<std::string>& trajectories, Points& points) {
  const Trajectory estimate = ReadStampedPoses("map compare", trajectories[0]);
  const Trajectory reference = ReadStampedPoses("map compare", trajectories[1]);
  const std::vector<StampMatch> matches = MatchByStamp(reference, estimate, 20'000'000);
  Eigen::Matrix3Xd a(3, matches.size()), b(3, matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    a.col(column) = reference[matches[i].reference].pose.p();
    b.col(column) = estimate[matches[i].estimate].pose.p();
  }
  const std::optional<Similarity> alignment = AlignUmeyama(a, b, false);
  if (!alignment) {
    throw IoError(trajectories[0], "cannot be aligned with " + trajectories[1] +
                                       ": of the positions at the same "
                                       "time there are " +
                                       std::to_string(matches.size()) +
                                       ", or all lie on one line: three that do not are needed");
  }
  const Pose T_RM = alignment->T_AB;
  for (Eigen::Vector3f& p : points) p = (T_RM * p.cast<double>()).cast<float>();
}

void KeepSeen(const CompareArguments& arguments, ReferenceSurface& reference) {
  const MapSource source = ResolveSource(arguments.seen_by, "", arguments.trajectory);
  const OpenedDataset opened = OpenWithConfig(
      arguments.config.empty() ? source.config : arguments.config, source.dataset, source.images);
  const RgbdSensor& sensor = opened.config.sensor;
  const Dataset& dataset = *opened.images;
  if (!source.run.empty()) RequireRecordingOfRun(source.dataset, dataset, source.run);
  std::vector<char> seen(reference.samples().size(), 0);
  const Trajectory trajectory = ReadStampedPoses("map compare", source.trajectory);
  for (const PosedFrame& frame : PosedFrames(dataset, trajectory, arguments.every)) {
    auto image = dataset.Load(frame.index);
    if (!image) continue;
    image->depth.setTo(0.0, image->depth > arguments.max_range);
    MarkSeen(reference.samples(), {image->depth, frame.T_WC}, sensor.camera, arguments.tolerance,
             seen);
  }
  reference.KeepSamples(seen);
}

nlohmann::ordered_json ComparisonJson(const DistanceStatistics& statistics) {
  return {{"mean", statistics.mean},
          {"median", statistics.median},
          {"percentile_90", statistics.percentile_90},
          {"count", statistics.count}};
}

nlohmann::ordered_json ComparisonJson(const MapComparison& comparison) {
  nlohmann::ordered_json json = {{"accuracy", ComparisonJson(comparison.accuracy)},
                                 {"completeness", ComparisonJson(comparison.completeness)},
                                 {"thresholds", nlohmann::ordered_json::array()}};
  for (const MapComparison::AtThreshold& at : comparison.thresholds) {
    json["thresholds"].push_back({{"threshold", at.threshold},
                                  {"precision", at.precision},
                                  {"recall", at.recall},
                                  {"f_score", at.f_score}});
  }
  return json;
}

void PrintTable(const MapComparison& comparison) {
  fmt::print("{:<13} {:>9} {:>9} {:>9} {:>10}\n", "distance [m]", "mean", "median", "90 %",
             "points");
  const auto row = [](const char* name, const DistanceStatistics& s) {
    fmt::print("{:<13} {:9.4f} {:9.4f} {:9.4f} {:>10}\n", name, s.mean, s.median, s.percentile_90,
               s.count);
  };
  row("accuracy", comparison.accuracy);
  row("completeness", comparison.completeness);
  fmt::print("\n{:<13} {:>9} {:>9} {:>9}\n", "within", "precision", "recall", "F-score");
  for (const MapComparison::AtThreshold& at : comparison.thresholds) {
    fmt::print("{:<13} {:9.4f} {:9.4f} {:9.4f}\n", fmt::format("{} cm", 100.0 * at.threshold),
               at.precision, at.recall, at.f_score);
  }
}

int RunCompare(const CompareArguments& arguments) {
  const MapComparison comparison = [&] {
    Progress progress("reading the maps");
    Points points = ReadPoints(arguments.map);
    ReferenceSurface reference = ReadReference(arguments.reference, arguments.spacing);
    if (!arguments.align.empty()) Align(arguments.align, points);
    if (!arguments.seen_by.empty()) KeepSeen(arguments, reference);
    progress.Begin("comparing");
    return CompareMaps(points, reference);
  }();
  if (arguments.json) {
    fmt::print("{}\n", JsonText(ComparisonJson(comparison)));
  } else {
    PrintTable(comparison);
  }
  return kExitOk;
}

}  // namespace

void AddMapCompareCommand(CLI::App& map, CommandAction& action) {
  const auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = map.add_subcommand(
      "compare", "Accuracy and completeness of a cloud or octree against a reference");
  command->add_option("map", arguments->map, "Cloud (.ply, .pcd) or octree (.bt, .ot)")->required();
  command->add_option("reference", arguments->reference, "Cloud, mesh (.ply with faces) or octree")
      ->required();
  command->add_option("--spacing", arguments->spacing, "Distance of the samples of a mesh [m]")
      ->check(Between(1e-3, 10.0))
      ->capture_default_str();
  CLI::Option* seen_by =
      command->add_option("--seen-by", arguments->seen_by,
                          "Dataset or run: only what its depth images show has to be complete");
  command->add_option("--trajectory", arguments->trajectory, "Its poses, in the reference's frame")
      ->needs(seen_by);
  command
      ->add_option("--config", arguments->config,
                   "Its calibration, as in highwall slam [default: that of the run]")
      ->needs(seen_by);
  command->add_option("--every", arguments->every, "Takes every n-th of its frames")
      ->needs(seen_by)
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "A surface that far off the depth measured was seen [m]")
      ->check(Between(1e-3, 10.0))
      ->capture_default_str();
  command
      ->add_option("--max-range", arguments->max_range,
                   "Its farther depth is ignored, as by highwall map [m]")
      ->check(Between(0.31, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--align", arguments->align,
                   "Trajectory of the map and of the reference: lays one on the other")
      ->expected(2);
  command->add_flag("--json", arguments->json, "One JSON object on standard output");
  // A run has its own frame: without --align its map would lie beside the reference.
  command->footer(
      "Example:\n  highwall map compare map/cloud.ply mine/surface.ply --seen-by mine \\\n"
      "      --align run/trajectory.txt mine/groundtruth.txt");
  command->callback(
      [arguments, &action] { action = [arguments] { return RunCompare(*arguments); }; });
}

}  // namespace highwall::apps
