// Computes a checksum of the result of each SLAM stage for each frame, so that two processors,
// compilers or builds can be compared stage by stage (scripts/compare_processors).
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <opencv2/core/mat.hpp>

#include <highwall/core/crc32.h>
#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/system/slam_system.h>

#include "bench_main.h"
#include "features/frame_builder.h"
#include "run/config.h"
#include "run/slam_arguments.h"

namespace highwall::bench {
namespace {

// Hashes the bytes of numbers, without padding.
class Checksum {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void Add(T number) {
    const std::byte* begin = reinterpret_cast<const std::byte*>(&number);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(T));
  }
  template <class Derived>
  void Add(const Eigen::DenseBase<Derived>& numbers) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) Add(numbers.derived().data()[i]);
  }
  void Add(const cv::Mat& image) {
    for (int row = 0; row < image.rows; ++row) {
      const auto* begin = reinterpret_cast<const std::byte*>(image.ptr(row));
      bytes_.insert(bytes_.end(), begin,
                    begin + static_cast<std::size_t>(image.cols) * image.elemSize());
    }
  }
  void Add(const Pose& pose) {
    Add(pose.p());
    Add(pose.q().coeffs());
  }
  std::uint32_t Value() const { return Crc32(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

void Print(std::int64_t frame, const char* stage, const Checksum& checksum, std::size_t count) {
  fmt::print("{:6} {:12} {:08x} {}\n", frame, stage, checksum.Value(), count);
}

void PrintImage(std::int64_t frame, const RgbdImage& image) {
  Checksum colour, depth;
  colour.Add(image.bgr);
  depth.Add(image.depth);
  Print(frame, "colour", colour, image.bgr.total());
  Print(frame, "depth", depth, image.depth.total());
}

void PrintFeatures(std::int64_t frame, const FrameFeatures& features) {
  Checksum points, descriptors, segments, line_descriptors, line_depths;
  for (const PointFeature& point : features.points) {
    points.Add(point.uv), points.Add(point.depth), points.Add(point.depth_sigma);
    points.Add(point.octave), points.Add(point.angle);
  }
  descriptors.Add(features.point_descriptors);
  for (const LineFeature& line : features.lines) {
    segments.Add(line.segment.s), segments.Add(line.segment.e);
    if (!line.segment_C) continue;
    line_depths.Add(line.segment_C->p_C), line_depths.Add(line.segment_C->q_C);
    line_depths.Add(line.segment_C->sigma_p), line_depths.Add(line.segment_C->sigma_q);
  }
  line_descriptors.Add(features.line_descriptors);
  Print(frame, "points", points, features.points.size());
  Print(frame, "descriptors", descriptors, features.points.size());
  Print(frame, "lines", segments, features.lines.size());
  Print(frame, "lbd", line_descriptors, features.lines.size());
  Print(frame, "line_depths", line_depths, features.lines.size());
}

void PrintResult(std::int64_t frame, const FrameResult& result) {
  Checksum matches, pose;
  matches.Add(result.matched_points), matches.Add(result.matched_lines);
  pose.Add(result.T_WC);
  Print(frame, "matches", matches,
        static_cast<std::size_t>(result.matched_points + result.matched_lines));
  Print(frame, "pose", pose, HasPose(result.state) ? 1 : 0);
}

void PrintMap(std::int64_t frame, const Map& map) {
  Checksum poses, points, lines;
  for (const KeyFrameId id : map.keyframe_ids()) poses.Add(map.keyframe(id)->T_WC);
  for (const PointId id : map.ids<MapPoint>()) points.Add(map.Find(id)->p_W);
  for (const LineId id : map.ids<MapLine>()) {
    lines.Add(map.Find(id)->segment_W.p()), lines.Add(map.Find(id)->segment_W.q());
  }
  Print(frame, "keyframes", poses, map.num_keyframes());
  Print(frame, "map_points", points, map.num<MapPoint>());
  Print(frame, "map_lines", lines, map.num<MapLine>());
}

void Run(const apps::SlamArguments& arguments) {
  const apps::ResolvedConfig config = apps::ResolveConfig(arguments.config, arguments.dataset);
  const RgbdSensor& sensor = config.config.sensor;
  const std::unique_ptr<const Dataset> dataset = OpenDataset(arguments.dataset, sensor);
  const SlamOptions options = Deterministic(apps::MakeOptions(arguments).slam);
  FrameBuilder builder(sensor, options.frame);
  SlamSystem system(sensor, options);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    const auto image = dataset->Load(i);
    if (!image) continue;
    PrintImage(frame, *image);
    PrintFeatures(frame, *builder.Build(*image));
    const FrameResult result = system.Track(*image);
    PrintResult(frame, result);
    if (result.mapping) PrintMap(frame, system.map());
  }
  system.Finish();
  PrintMap(static_cast<std::int64_t>(dataset->size()), system.map());
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  highwall::apps::SlamArguments arguments;
  return highwall::bench::RunBench(
      {"highwall_bench_stages",
       "A checksum of the result of each stage for each frame, from images alone.\n"
       "Example: highwall_bench_stages --dataset fr1_xyz --config tum1 --line-detector lsd"},
      argc, argv,
      [&](CLI::App& app) {
        highwall::apps::AddSlamOptions(&app, &arguments);
        app.get_option("--out")->required(false);
      },
      [&] { highwall::bench::Run(arguments); });
}
