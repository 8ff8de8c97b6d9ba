#include <ceres/loss_function.h>
#include <highwall/core/line3.h>
#include <highwall/core/relative_pose.h>
#include <highwall/factors/position.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "features/depth_grid.h"
#include "fuzz.h"
#include "support/crc32.h"

namespace highwall::fuzz {
namespace {

constexpr std::size_t kHeaderSize = 24;  // docs/map_file.md

// So low that its depth grid is as small as typical inputs.
PinholeCamera FlatCamera() {
  PinholeCamera camera;
  camera.height = 12;
  camera.cy = 6.0;
  return camera;
}

// A map with two views of two points and a line.
Map SmallMap(const cv::Mat& depth_grid = {}) {
  auto features = std::make_shared<FrameFeatures>();
  for (const double u : {100.0, 300.0}) {
    PointFeature point;
    point.uv = {u, 200.0};
    point.depth = 2.0;
    point.depth_sigma = 0.01;
    point.octave = 1;
    features->points.push_back(point);
  }
  features->point_descriptors = cv::Mat(2, 32, CV_8U, cv::Scalar(7));
  SegmentDepth depth;
  depth.p_C = {0, 0, 2};
  depth.q_C = {1, 0, 2};
  depth.sigma_p = depth.sigma_q = 0.01;
  depth.inlier_share = 1.0;
  features->lines.push_back({{{10.0f, 10.0f}, {200.0f, 12.0f}}, depth});
  features->line_descriptors = cv::Mat(1, 32, CV_8U, cv::Scalar(9));
  features->depth_grid = depth_grid;
  Map map;
  const KeyFrameId a = map.AddKeyFrame({0, 1'000, features}, Pose()).id;
  const KeyFrameId b =
      map.AddKeyFrame({1, 2'000, features}, Pose::FromTangent({0.1, 0, 0}, {0, 0, 0})).id;
  for (const int i : {0, 1}) {
    const PointId id = map.Add<MapPoint>({0.5 * i, 0.0, 2.0}, 0).id;
    map.Observe(a, i, id);
    map.Observe(b, i, id);
    map.RefreshPoint(id, {});
  }
  const LineId line = map.Add<MapLine>({{0, 0, 2}, {1, 0, 2}}, 0).id;
  map.Observe(a, 0, line);
  map.Observe(b, 0, line);
  return map;
}

// A map with the depth around each view and a second world with a known gravity direction.
Map TwoWorlds() {
  Map map = SmallMap(cv::Mat(DepthGrid::SizeFor(FlatCamera()), CV_32FC1, cv::Scalar(2.0)));
  const SubmapId other = map.AddSubmap();
  map.AddKeyFrame({2, 3'000, std::make_shared<FrameFeatures>()}, Pose(), other).found = 30.0;
  map.SetGravity(Eigen::Vector3d(0, 0, -9.81), other);
  return map;
}

// A map with the position of an antenna.
Map Measured() {
  Map map = SmallMap();
  const ReferenceFrameId frame = map.factors().AddFrame({});
  map.factors().Place(frame, kFirstSubmap, Pose::FromTangent({1, 2, 3}, {0, 0, 1}));
  map.AddFactor({{{map.keyframe_ids().front(), Pose()}},
                 frame,
                 std::make_shared<PositionFactor>(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d::Zero(),
                                                  Eigen::Matrix3d::Identity()),
                 std::make_shared<ceres::HuberLoss>(3.0)});
  return map;
}

// The same with a motion between the two views.
Map Moved() {
  Map map = Measured();
  map.AddFactor({{{map.keyframe_ids().front(), Pose()}, {map.keyframe_ids().back(), Pose()}},
                 kNoId,
                 std::make_shared<RelativePose>(Pose::FromTangent({0.1, 0, 0}, {0, 0, 0}),
                                                Eigen::Matrix<double, 6, 6>::Identity()),
                 nullptr});
  return map;
}

// Returns the version and then the content of the file after its header. For older versions this is
// no complete map, because only the newest layout is written. Their readers start where it is the
// same.
std::string Input(char version, const PinholeCamera& camera, const Map& map) {
  return version +
         Written([&](const auto& path) { SaveMap(path, camera, map); }).substr(kHeaderSize);
}

// The first operations of a run on a loaded map must not throw.
void Use(SavedMap saved) {
  RgbdSensor sensor;
  sensor.camera = saved.camera;
  const MeasurementModel model(sensor, {});
  for (const KeyFrameId id : saved.map.keyframe_ids()) {
    const FrameFeatures& features = *saved.map.keyframe(id)->frame.features;
    for (const PointFeature& point : features.points) {
      model.Rows(point);
      model.MakeFactor(point);
    }
    for (const LineFeature& line : features.lines) {
      model.Rows(line);
      model.MakeFactor(line);
    }
    saved.map.Covisible(id, 1);
  }
  for (const SubmapId root : saved.map.roots()) {
    for (const KeyFrameId id : saved.map.KeyFramesOf(root)) saved.map.IsOrigin(id);
    saved.map.gravity_W(root);
  }
  for (const PointId id : saved.map.ids<MapPoint>()) saved.map.RefreshPoint(id, {});
  for (const LineId id : saved.map.ids<MapLine>()) {
    const Segment3& segment_W = saved.map.Find(id)->segment_W;
    OrthonormalLine(PluckerLine::FromPoints(segment_W.p(), segment_W.q()));
  }
  for (const MapFactor& factor : saved.map.factors().all()) {
    const Pose T_WB, T_FW;
    const double* const blocks[] = {T_WB.data(), T_FW.data()};
    double residuals[6];  // of a motion; a position has three
    factor.cost->Evaluate(blocks, residuals, nullptr);
  }
  saved.map.Transform(Pose::FromTangent({1, 2, 3}, {0.1, 0.2, 0.3}));
}

}  // namespace

const Target kTarget{
    .file_name = "saved.hwmap",
    .seeds =
        [] {
          std::vector<std::string> seeds;
          for (const char version : {1, 2, 3}) {
            seeds.push_back(Input(version, PinholeCamera(), SmallMap()));
            seeds.push_back(Input(version, FlatCamera(), TwoWorlds()));
            seeds.push_back(Input(version, PinholeCamera(), Map()));
          }
          seeds.push_back(Input(4, PinholeCamera(), Measured()));
          seeds.push_back(Input(6, PinholeCamera(), Moved()));
          return seeds;
        },
    // The header is corrected, because a checksum does not authenticate the writer.
    .file =
        [](std::string_view input) {
          std::string file = "HWMAP\r\n\x1a";
          file.resize(kHeaderSize);
          const std::string_view content = input.substr(std::min<std::size_t>(1, input.size()));
          const std::uint32_t version = input.empty() ? 4 : static_cast<unsigned char>(input[0]);
          const std::uint32_t crc = testing::Crc32(content);
          const std::uint64_t size = content.size();
          std::memcpy(file.data() + 8, &version, 4);
          std::memcpy(file.data() + 12, &crc, 4);
          std::memcpy(file.data() + 16, &size, 8);
          return file.append(content);
        },
    .read = [](const std::filesystem::path& path) { Use(LoadMap(path)); },
};

}  // namespace highwall::fuzz
