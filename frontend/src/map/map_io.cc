#include <highwall/frontend/map/map.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include <opencv2/core/types.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/crc32.h>
#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor.h>

#include "features/depth_grid.h"
#include "map/map_archive.h"
#include "map/map_factor_io.h"

namespace highwall {
namespace {

static_assert(std::endian::native == std::endian::little, "map files are little-endian");

constexpr std::array<char, 8> kMagic = {'H', 'W', 'M', 'A', 'P', '\r', '\n', '\x1a'};
constexpr std::uint32_t kVersion = 6;
// Older versions are read as well: missing values are unknown, and their points are ORB.
constexpr std::uint32_t kFirstVersion = 1, kFirstWithSubmaps = 2, kFirstWithDepth = 3;
// Since version 4: the kind of points, the noise of features, the user factors.
constexpr std::uint32_t kFirstWithKind = 4;
// Since version 5: which corners were refined.
constexpr std::uint32_t kFirstWithRefined = 5;
// Since version 6: motions measured by users. A map without them is written as version 5.
constexpr std::uint32_t kFirstWithMotions = 6;
// Magic, version, CRC-32 of the content, bytes of the content.
constexpr std::size_t kHeaderSize = 8 + 4 + 4 + 8;

// How a kind of landmark is stored: the bytes that a feature and a landmark take at least, and the
// descriptors of its features.
template <class Landmark>
struct Stored;
template <>
struct Stored<MapPoint> {
  static constexpr std::size_t kFeatureBytes = 40, kLandmarkBytes = 100;
  static constexpr auto kDescriptors = &FrameFeatures::point_descriptors;
};
template <>
struct Stored<MapLine> {
  static constexpr std::size_t kFeatureBytes = 17, kLandmarkBytes = 90;
  static constexpr auto kDescriptors = &FrameFeatures::line_descriptors;
};

// Bounds of plausible values.
constexpr int kLargestImage = 1 << 14;                   // [px]
constexpr int kMostOctaves = 16;                         // PyramidOptions::levels
constexpr std::int64_t kLatest = std::int64_t{1} << 62;  // differences remain representable
constexpr std::int32_t kMostObservations = std::int32_t{1} << 30;  // leaves room for counting

// A run on the map is made with this camera, so that it must be valid as a sensor's.
void Check(const MapReader& reader, const PinholeCamera& camera) {
  RgbdSensor sensor;
  sensor.camera = camera;
  sensor.Validate();
  reader.Require(camera.width <= kLargestImage && camera.height <= kLargestImage &&
                     IsBetween(kSmallest, camera.fx, kLargest) &&
                     IsBetween(kSmallest, camera.fy, kLargest) &&
                     IsBounded(Eigen::Vector2d(camera.cx, camera.cy)),
                 "no camera is like its camera");
}

void Check(const MapReader& reader, const PointFeature& point) {
  reader.Require(IsBounded(point.uv), "a point is nowhere in its image");
  reader.Require(IsBetween(0, point.octave, kMostOctaves - 1), "a point is of no pyramid level");
  reader.Require(std::isfinite(point.angle), "a point has no angle");
  reader.Require(point.depth == 0.0 || (IsBetween(kSmallest, point.depth, kLargest) &&
                                        IsBetween(kSmallest, point.depth_sigma, kLargest)),
                 "a point's depth or its sigma is not positive");
}

void Check(const MapReader& reader, const LineFeature& line) {
  // An image line of less than a pixel has no direction; its factors reject it.
  reader.Require(IsBounded(line.segment.s) && IsBounded(line.segment.e) &&
                     (line.segment.e - line.segment.s).cast<double>().norm() >= 1.0,
                 "a line's ends in its image are one");
  if (!line.segment_C) return;
  const SegmentDepth& depth = *line.segment_C;
  reader.Require(IsBounded(depth.p_C) && IsBounded(depth.q_C) && depth.p_C.z() >= kSmallest &&
                     depth.q_C.z() >= kSmallest,
                 "a line's end is not in front of its camera");
  reader.Require(IsBetween(0.0, depth.sigma_p, kLargest) &&
                     IsBetween(0.0, depth.sigma_q, kLargest) &&
                     IsBetween(0.0, depth.inlier_share, 1.0) && IsBetween(0.0, depth.rms, kLargest),
                 "a line's depth is not as good as any can be");
}

template <class Landmark>
void CheckCounts(const MapReader& reader, const Landmark& landmark) {
  reader.Require(IsBetween(1, landmark.visible, kMostObservations) &&
                     IsBetween(0, landmark.found, kMostObservations),
                 "a landmark's observations are not counted");
  reader.Require(IsBetween(-kLatest, landmark.first_frame, kLatest),
                 "a landmark's first frame is beyond all");
}

void Check(const MapReader& reader, const MapPoint& point) {
  reader.Require(IsBounded(point.p_W), "a point is nowhere");
  reader.Require(point.normal_W.norm() <= 1.0 + kUnitRounding, "a point is seen from nowhere");
  reader.Require(0.0 <= point.min_distance && point.min_distance <= point.max_distance &&
                     point.max_distance <= kLargest,
                 "a point is seen from no distance");
  CheckCounts(reader, point);
}

void Check(const MapReader& reader, const MapLine& line) {
  const Eigen::Vector3d p = line.segment_W.p(), q = line.segment_W.q();
  // Requirement of PluckerLine::FromPoints.
  reader.Require(IsBounded(p) && IsBounded(q) && (q - p).norm() > kSmallest,
                 "a line's ends are one, or nowhere");
  CheckCounts(reader, line);
}

// Fields of each type, for reading and writing.
template <class Archive, class Camera>
void Fields(Archive& archive,
            Camera& camera) requires std::is_same_v<std::remove_const_t<Camera>, PinholeCamera> {
  archive(camera.width);
  archive(camera.height);
  archive(camera.fx);
  archive(camera.fy);
  archive(camera.cx);
  archive(camera.cy);
}

template <class Archive, class Feature>
void Fields(Archive& archive,
            Feature& feature) requires std::is_same_v<std::remove_const_t<Feature>, PointFeature> {
  Doubles(archive, feature.uv);
  archive(feature.depth);
  archive(feature.depth_sigma);
  archive(feature.octave);
  archive(feature.angle);
}

template <class Archive, class Depth>
void Fields(Archive& archive,
            Depth& depth) requires std::is_same_v<std::remove_const_t<Depth>, SegmentDepth> {
  Doubles(archive, depth.p_C);
  Doubles(archive, depth.q_C);
  archive(depth.sigma_p);
  archive(depth.sigma_q);
  archive(depth.inlier_share);
  archive(depth.rms);
  archive(depth.depth_edge);
}

template <class Archive, class Landmark>
void CommonFields(Archive& archive, Landmark& landmark) {
  archive.Bytes(landmark.descriptor.data(), landmark.descriptor.size());
  archive(landmark.first_frame);
  archive(landmark.visible);
  archive(landmark.found);
}

template <class Archive, class Landmark>
void Fields(Archive& archive,
            Landmark& point) requires std::is_same_v<std::remove_const_t<Landmark>, MapPoint> {
  Doubles(archive, point.p_W);
  Doubles(archive, point.normal_W);
  archive(point.min_distance);
  archive(point.max_distance);
  CommonFields(archive, point);
}

template <class Archive, class Landmark>
void Fields(Archive& archive,
            Landmark& line) requires std::is_same_v<std::remove_const_t<Landmark>, MapLine> {
  archive.Bytes(line.segment_W.data(), sizeof(double) * Segment3::kSize);
  archive(line.has_descriptor);
  CommonFields(archive, line);
}

template <class Archive, class Kind>
void KindFields(Archive& archive, Kind& kind) {
  archive(kind.columns);
  archive(kind.pyramid.levels);
  archive(kind.pyramid.scale_factor);
  archive(kind.low_contrast_response);
}

void WriteKind(MapWriter& writer, const FeatureType& kind) {
  writer(static_cast<std::uint32_t>(kind.name.size()));
  writer.Bytes(kind.name.data(), kind.name.size());
  writer(kind.descriptor == DescriptorType::kFloat);
  KindFields(writer, kind);
}

FeatureType ReadKind(MapReader& reader) {
  FeatureType kind;
  kind.name = reader.String();
  bool is_float = false;
  reader(is_float);
  kind.descriptor = is_float ? DescriptorType::kFloat : DescriptorType::kBinary;
  KindFields(reader, kind);
  kind.Validate();
  return kind;
}

void WriteDescriptors(MapWriter& writer, const cv::Mat& descriptors) {
  writer(static_cast<std::uint32_t>(descriptors.rows));
  for (int i = 0; i < descriptors.rows; ++i) writer.Bytes(descriptors.ptr(i), 32);
}

cv::Mat ReadDescriptors(MapReader& reader) {
  const auto rows = static_cast<int>(reader.Count(32));
  if (rows == 0) return {};
  cv::Mat descriptors(rows, 32, CV_8U);
  reader.Bytes(descriptors.data, 32 * static_cast<std::size_t>(rows));
  return descriptors;
}

template <class Feature>
void WriteFeature(MapWriter& writer, const Feature& feature) {
  Fields(writer, feature);
}

void WriteFeature(MapWriter& writer, const LineFeature& line) {
  Doubles(writer, line.segment.s);
  Doubles(writer, line.segment.e);
  writer(line.segment_C.has_value());
  if (line.segment_C) Fields(writer, *line.segment_C);
}

template <class Feature>
void ReadFeature(MapReader& reader, Feature& feature) {
  Fields(reader, feature);
}

void ReadFeature(MapReader& reader, LineFeature& line) {
  Doubles(reader, line.segment.s);
  Doubles(reader, line.segment.e);
  bool has_depth = false;
  reader(has_depth);
  if (has_depth) Fields(reader, line.segment_C.emplace());
}

void WriteFeatures(MapWriter& writer, const FrameFeatures& features) {
  ForEachKind([&]<class Landmark>() {
    const auto& list = PartOf<Landmark>(features);
    writer(static_cast<std::uint32_t>(list.size()));
    for (const auto& feature : list) WriteFeature(writer, feature);
    WriteDescriptors(writer, features.*Stored<Landmark>::kDescriptors);
  });
}

std::shared_ptr<FrameFeatures> ReadFeatures(MapReader& reader, const PinholeCamera& camera) {
  auto features = std::make_shared<FrameFeatures>();
  ForEachKind([&]<class Landmark>() {
    auto& list = PartOf<Landmark>(*features);
    for (std::uint32_t i = reader.Count(Stored<Landmark>::kFeatureBytes); i > 0; --i) {
      auto& feature = list.emplace_back();
      ReadFeature(reader, feature);
      Check(reader, feature);
    }
    (*features).*Stored<Landmark>::kDescriptors = ReadDescriptors(reader);
  });
  features->point_grid = GridOf(features->points, {camera.width, camera.height});
  bool fits = features->point_descriptors.empty() == features->points.empty();
  ForEachKind([&]<class Landmark>() {
    const cv::Mat& descriptors = (*features).*Stored<Landmark>::kDescriptors;
    fits = fits && (descriptors.empty() || static_cast<std::size_t>(descriptors.rows) ==
                                               PartOf<Landmark>(*features).size());
  });
  reader.Require(fits, "there is not one descriptor a feature");
  return features;
}

// Writes the reference against which another map of the same place is checked.
void WriteEvidence(MapWriter& writer, const KeyFrame& keyframe) {
  const cv::Mat& grid = keyframe.depth_grid;
  writer(keyframe.found);
  writer(static_cast<std::uint32_t>(grid.total()));
  for (int v = 0; v < grid.rows; ++v) {
    writer.Bytes(grid.ptr(v), sizeof(float) * static_cast<std::size_t>(grid.cols));
  }
}

// size: of the depth grid, in cells.
double ReadEvidence(MapReader& reader, const cv::Size& size, FrameFeatures& features) {
  double found = 0.0;
  reader(found);
  reader.Require(IsBetween(0.0, found, kLargest), "a keyframe has found less than nothing");
  const std::uint32_t cells = reader.Count(sizeof(float));
  if (cells == 0) return found;
  reader.Require(cells == static_cast<std::uint32_t>(size.area()),
                 "its depth is not that of its camera");
  features.depth_grid.create(size, CV_32FC1);
  reader.Bytes(features.depth_grid.data, sizeof(float) * cells);
  const auto is_depth = [](float z) { return IsBetween(0.0F, z, static_cast<float>(kLargest)); };
  reader.Require(
      std::all_of(features.depth_grid.begin<float>(), features.depth_grid.end<float>(), is_depth),
      "a depth is none");
  return found;
}

void WriteNoise(MapWriter& writer, const FrameFeatures& features) {
  const auto write = [&](const auto& feature) {
    writer(feature.noise.px);
    writer(feature.noise.depth);
  };
  ForEachKind([&]<class Landmark>() {
    for (const auto& feature : PartOf<Landmark>(features)) {
      write(feature);
      if constexpr (std::is_same_v<Landmark, MapPoint>) writer(feature.refined);
    }
  });
}

void ReadNoise(MapReader& reader, bool tells_refined, FrameFeatures& features) {
  const auto read = [&](auto& feature) {
    reader(feature.noise.px);
    reader(feature.noise.depth);
    const auto is_factor = [](float factor) {
      return IsBetween(static_cast<float>(kSmallest), factor, static_cast<float>(kLargest));
    };
    reader.Require(is_factor(feature.noise.px) && is_factor(feature.noise.depth),
                   "a feature's noise is none");
  };
  ForEachKind([&]<class Landmark>() {
    for (auto& feature : PartOf<Landmark>(features)) {
      read(feature);
      if constexpr (std::is_same_v<Landmark, MapPoint>) {
        if (tells_refined) reader(feature.refined);
      }
    }
  });
}

template <class Landmark>
void WriteLandmark(MapWriter& writer, const Landmark& landmark,
                   const std::unordered_map<KeyFrameId, std::int32_t>& ranks) {
  Fields(writer, landmark);
  writer(static_cast<std::uint32_t>(landmark.observations.size()));
  for (const Observation& o : landmark.observations) {
    writer(ranks.at(o.keyframe));
    writer(o.index);
  }
}

template <class Landmark>
void WriteLandmarks(MapWriter& writer, const Map& map,
                    const std::unordered_map<KeyFrameId, std::int32_t>& ranks) {
  writer(static_cast<std::uint32_t>(map.num<Landmark>()));
  for (const Id<Landmark> id : map.ids<Landmark>()) WriteLandmark(writer, *map.Find(id), ranks);
}

// Reads a landmark with its observations and adds it to the map.
template <class Landmark>
void ReadLandmark(MapReader& reader, Map& map) {
  const Landmark blank{};
  Landmark& landmark = map.Add<Landmark>(LandmarkTraits<Landmark>::PositionOf(blank), 0);
  Fields(reader, landmark);
  Check(reader, landmark);
  const std::uint32_t observations = reader.Count(8);
  reader.Require(observations > 0, "a landmark is seen by nothing");
  for (std::uint32_t i = 0; i < observations; ++i) {
    Observation o;
    reader(o.keyframe);
    reader(o.index);
    const KeyFrame* keyframe = map.keyframe(o.keyframe);
    reader.Require(keyframe != nullptr && o.index >= 0 &&
                       static_cast<std::size_t>(o.index) < PartOf<Landmark>(*keyframe).size() &&
                       map.Observe(o.keyframe, o.index, landmark.id),
                   "an observation of a landmark has no keyframe or occurs twice");
  }
}

// Writes the submaps that have keyframes, in their order; each is identified by its rank.
std::map<SubmapId, std::int32_t> WriteSubmaps(MapWriter& writer, const Map& map) {
  std::map<SubmapId, std::int32_t> ranks;
  for (const KeyFrameId id : map.keyframe_ids()) ranks.emplace(map.keyframe(id)->submap, 0);
  std::int32_t next = 0;
  for (auto& [submap, rank] : ranks) rank = next++;
  writer(static_cast<std::uint32_t>(ranks.size()));
  for (const auto& [submap, rank] : ranks) {
    // The origin of a world is never removed, so the root is among them.
    writer(ranks.at(map.Root(submap)));
    const auto& gravity_W = map.gravity_W(submap);
    writer(gravity_W.has_value());
    if (gravity_W) Doubles(writer, *gravity_W);
  }
  return ranks;
}

// Returns their number.
std::uint32_t ReadSubmaps(MapReader& reader, Map& map) {
  const std::uint32_t count = reader.Count(5);
  for (std::uint32_t i = 0; i < count; ++i) {
    const SubmapId submap = i == 0 ? kFirstSubmap : map.AddSubmap();
    SubmapId root;
    reader(root);
    reader.Require(root > kNoId && root <= submap && map.Root(root) == root,
                   "a submap is joined with none");
    map.Join(root, submap);
    bool has_gravity = false;
    reader(has_gravity);
    if (!has_gravity) continue;
    Eigen::Vector3d gravity_W;
    Doubles(reader, gravity_W);
    reader.Require(IsBounded(gravity_W) && gravity_W.norm() > kSmallest, "its gravity is none");
    map.SetGravity(gravity_W, submap);
  }
  return count;
}

std::string Encode(const PinholeCamera& camera, const Map& map) {
  MapWriter writer;
  Fields(writer, camera);
  WriteKind(writer, map.feature_type());
  const std::map<SubmapId, std::int32_t> submaps = WriteSubmaps(writer, map);
  std::unordered_map<KeyFrameId, std::int32_t> ranks;
  writer(static_cast<std::uint32_t>(map.num_keyframes()));
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    ranks.emplace(id, static_cast<std::int32_t>(ranks.size()));
    writer(submaps.at(keyframe.submap));
    writer(keyframe.frame.index);
    writer(keyframe.frame.stamp);
    WritePose(writer, keyframe.T_WC);
    WriteFeatures(writer, *keyframe.frame.features);
    WriteEvidence(writer, keyframe);
    WriteNoise(writer, *keyframe.frame.features);
  }
  ForEachKind([&]<class Landmark>() { WriteLandmarks<Landmark>(writer, map, ranks); });
  WriteFactors(writer, map, submaps, ranks);
  return writer.content();
}

SavedMap Decode(MapReader& reader, std::uint32_t version) {
  SavedMap saved;
  Fields(reader, saved.camera);
  Check(reader, saved.camera);
  Map& map = saved.map;
  if (version >= kFirstWithKind) map.SetFeatureType(ReadKind(reader));
  const cv::Size grid_size = DepthGrid::SizeFor(saved.camera);
  const bool has_submaps = version >= kFirstWithSubmaps;
  const std::uint32_t submaps = has_submaps ? ReadSubmaps(reader, map) : 1;
  std::vector<bool> populated(submaps, false);
  for (std::uint32_t i = reader.Count(72); i > 0; --i) {
    SubmapId submap = kFirstSubmap;
    if (has_submaps) reader(submap);
    reader.Require(submap.index() < submaps, "a keyframe is of no submap");
    populated[submap.index()] = true;
    Frame frame;
    reader(frame.index);
    reader(frame.stamp);
    reader.Require(
        IsBetween(-kLatest, frame.index, kLatest) && IsBetween(-kLatest, frame.stamp, kLatest),
        "a keyframe's time is beyond all");
    const Pose T_WC = ReadPose(reader, "a keyframe's pose is none");
    const auto features = ReadFeatures(reader, saved.camera);
    const double found =
        version >= kFirstWithDepth ? ReadEvidence(reader, grid_size, *features) : 0.0;
    if (version >= kFirstWithKind) ReadNoise(reader, version >= kFirstWithRefined, *features);
    frame.features = features;
    map.AddKeyFrame(frame, T_WC, submap).found = found;
  }
  for (const KeyFrameId id : map.keyframe_ids()) {
    reader.Require(populated[map.Root(map.keyframe(id)->submap).index()],
                   "a submap is joined with one that has no keyframe");
  }
  ForEachKind([&]<class Landmark>() {
    for (std::uint32_t i = reader.Count(Stored<Landmark>::kLandmarkBytes); i > 0; --i) {
      ReadLandmark<Landmark>(reader, map);
    }
  });
  if (version >= kFirstWithKind) ReadFactors(reader, submaps, version >= kFirstWithMotions, &map);
  reader.RequireEnd();
  return saved;
}

}  // namespace

std::size_t SaveMap(const std::filesystem::path& path, const PinholeCamera& camera,
                    const Map& map) {
  const std::string content = Encode(camera, map);
  MapWriter header;
  header.Bytes(kMagic.data(), kMagic.size());
  header(HasMotions(map) ? kFirstWithMotions : kFirstWithRefined);
  header(Crc32(std::as_bytes(std::span(content))));
  header(static_cast<std::uint64_t>(content.size()));
  AtomicFile file(path);
  file.stream() << header.content() << content;
  file.Commit();
  return static_cast<std::size_t>(std::ranges::count_if(
      map.factors().all(), [](const MapFactor& factor) { return !CanWrite(factor); }));
}

SavedMap LoadMap(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw IoError(path, "is a folder, not a map: give the file, as map.hwmap in that of a run");
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw IoError(path, "cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) throw IoError(path, "cannot be read");
  if (bytes.compare(0, kMagic.size(), kMagic.data(), kMagic.size()) != 0) {
    throw IoError(path, "is no map of Highwall");
  }
  if (bytes.size() < kHeaderSize) throw IoError(path, "is cut short");
  MapReader header(path, bytes.data() + kMagic.size(), kHeaderSize - kMagic.size());
  std::uint32_t version = 0, crc = 0;
  std::uint64_t size = 0;
  header(version);
  header(crc);
  header(size);
  if (version < kFirstVersion || version > kVersion) {
    throw IoError(path, "is a map of version " + std::to_string(version) + ", not " +
                            std::to_string(kVersion) + " or older: make it again");
  }
  const char* const content = bytes.data() + kHeaderSize;
  if (bytes.size() - kHeaderSize < size) throw IoError(path, "is cut short");
  if (bytes.size() - kHeaderSize > size || Crc32(std::as_bytes(std::span(content, size))) != crc) {
    throw IoError(path, "is damaged: its checksum does not fit");
  }
  MapReader reader(path, content, size);
  try {
    return Decode(reader, version);
  } catch (const InvalidArgument& e) {  // invalid camera or kind of points
    throw IoError(path, std::string("is damaged: ") + e.what());
  }
}

}  // namespace highwall
