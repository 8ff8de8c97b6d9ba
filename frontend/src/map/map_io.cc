#include <highwall/frontend/map/map.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include <opencv2/core/types.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/crc32.h>
#include <highwall/core/error.h>

#include "features/depth_grid.h"

namespace highwall {
namespace {

static_assert(std::endian::native == std::endian::little, "map files are little-endian");

constexpr std::array<char, 8> kMagic = {'H', 'W', 'M', 'A', 'P', '\r', '\n', '\x1a'};
constexpr std::uint32_t kVersion = 4;
// Older ones are read as well: what they lack is not known, and their points are ORB's.
constexpr std::uint32_t kFirstVersion = 1, kFirstWithSubmaps = 2, kFirstWithDepth = 3,
                        kFirstWithKind = 4;
// Magic, version, CRC-32 of the content, bytes of the content.
constexpr std::size_t kHeaderSize = 8 + 4 + 4 + 8;

// Appends values to the content of a file.
class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void Bytes(const void* data, std::size_t size) {
    content_.append(static_cast<const char*>(data), size);
  }
  const std::string& content() const { return content_; }

 private:
  std::string content_;
};

// Takes values from the content of a file, in the same order.
class Reader {
 public:
  Reader(const std::filesystem::path& path, const char* data, std::size_t size)
      : path_(path), data_(data), end_(data + size) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    Bytes(&byte, 1);
    Require(byte <= 1, "a yes or no is neither");
    value = byte == 1;
  }
  template <class Tag>
  void operator()(Id<Tag>& id) {
    std::int32_t number = 0;
    (*this)(number);
    id = Id<Tag>(number);
  }
  void Bytes(void* data, std::size_t size) {
    Require(size <= static_cast<std::size_t>(end_ - data_), "a part of it is missing");
    std::memcpy(data, data_, size);
    data_ += size;
  }
  std::string String() {
    std::string text(Count(1), '\0');
    Bytes(text.data(), text.size());
    return text;
  }
  // Of things that take at least `bytes` each.
  std::uint32_t Count(std::size_t bytes) {
    std::uint32_t count = 0;
    (*this)(count);
    Require(count <= static_cast<std::size_t>(end_ - data_) / bytes, "a count is beyond its end");
    return count;
  }
  void RequireEnd() const { Require(data_ == end_, "there is more than was counted"); }
  void Require(bool condition, const char* what) const {
    if (!condition) throw IoError(path_, std::string("is damaged: ") + what);
  }

 private:
  const std::filesystem::path& path_;
  const char* data_;
  const char* end_;
};

// Bounds of what is believed, so that what was loaded can be used: beyond any image and any place
// on Earth [px, m], and squares and products are still numbers.
constexpr double kLargest = 1e9, kSmallest = 1e-9;
constexpr double kRounding = 1e-6;                                 // of what has unit length
constexpr int kLargestImage = 1 << 14;                             // [px]
constexpr int kMostOctaves = 16;                                   // OrbExtractorOptions::levels
constexpr std::int64_t kLatest = std::int64_t{1} << 62;            // differences are still numbers
constexpr std::int32_t kMostObservations = std::int32_t{1} << 30;  // counting goes on from here

template <class T>
bool IsBetween(T low, T value, T high) {
  return low <= value && value <= high;
}

template <class Matrix>
bool IsBounded(const Matrix& matrix) {
  return (matrix.array().abs() <= static_cast<typename Matrix::Scalar>(kLargest)).all();
}

void Check(const Reader& reader, const PinholeCamera& camera) {
  camera.Validate();
  reader.Require(camera.width <= kLargestImage && camera.height <= kLargestImage &&
                     IsBetween(kSmallest, camera.fx, kLargest) &&
                     IsBetween(kSmallest, camera.fy, kLargest) &&
                     IsBounded(Eigen::Vector2d(camera.cx, camera.cy)),
                 "no camera is like its camera");
}

void Check(const Reader& reader, const PointFeature& point) {
  reader.Require(IsBounded(point.uv), "a point is nowhere in its image");
  reader.Require(IsBetween(0, point.octave, kMostOctaves - 1), "a point is of no pyramid level");
  reader.Require(std::isfinite(point.angle), "a point has no angle");
  reader.Require(point.depth == 0.0 || (IsBetween(kSmallest, point.depth, kLargest) &&
                                        IsBetween(kSmallest, point.depth_sigma, kLargest)),
                 "a point's depth or its sigma is not positive");
}

void Check(const Reader& reader, const LineFeature& line) {
  // An image line of less than a pixel has no direction; its factors refuse it.
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
void CheckCounts(const Reader& reader, const Landmark& landmark) {
  reader.Require(IsBetween(1, landmark.visible, kMostObservations) &&
                     IsBetween(0, landmark.found, kMostObservations),
                 "a landmark's observations are not counted");
  reader.Require(IsBetween(-kLatest, landmark.first_frame, kLatest),
                 "a landmark's first frame is beyond all");
}

void Check(const Reader& reader, const MapPoint& point) {
  reader.Require(IsBounded(point.p_W), "a point is nowhere");
  reader.Require(point.normal_W.norm() <= 1.0 + kRounding, "a point is seen from nowhere");
  reader.Require(0.0 <= point.min_distance && point.min_distance <= point.max_distance &&
                     point.max_distance <= kLargest,
                 "a point is seen from no distance");
  CheckCounts(reader, point);
}

void Check(const Reader& reader, const MapLine& line) {
  const Eigen::Vector3d p = line.segment_W.p(), q = line.segment_W.q();
  // What PluckerLine::FromPoints wants.
  reader.Require(IsBounded(p) && IsBounded(q) && (q - p).norm() > kSmallest,
                 "a line's ends are one, or nowhere");
  CheckCounts(reader, line);
}

// T_WC as it was stored, which may only be a rounding away from a unit quaternion.
Pose CheckedPose(const Reader& reader, const std::array<double, Pose::kSize>& block) {
  const Eigen::Map<const Eigen::Vector3d> p(block.data());
  const Eigen::Map<const Eigen::Vector4d> q(block.data() + 3);
  reader.Require(IsBounded(Eigen::Vector3d(p)) && std::abs(q.norm() - 1.0) <= kRounding,
                 "a keyframe's pose is none");
  return Pose::FromBlock(block.data());
}

// Each type's fields, for both directions.
template <class Archive, class Matrix>
void Doubles(Archive& archive, Matrix& matrix) {
  archive.Bytes(matrix.data(), sizeof(*matrix.data()) * static_cast<std::size_t>(matrix.size()));
}

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
  archive(kind.faint_response);
}

void WriteKind(Writer& writer, const PointKind& kind) {
  writer(static_cast<std::uint32_t>(kind.name.size()));
  writer.Bytes(kind.name.data(), kind.name.size());
  writer(kind.descriptor == DescriptorType::kFloat);
  KindFields(writer, kind);
}

PointKind ReadKind(Reader& reader) {
  PointKind kind;
  kind.name = reader.String();
  bool is_float = false;
  reader(is_float);
  kind.descriptor = is_float ? DescriptorType::kFloat : DescriptorType::kBinary;
  KindFields(reader, kind);
  kind.Validate();
  return kind;
}

void WriteDescriptors(Writer& writer, const cv::Mat& descriptors) {
  writer(static_cast<std::uint32_t>(descriptors.rows));
  for (int i = 0; i < descriptors.rows; ++i) writer.Bytes(descriptors.ptr(i), 32);
}

cv::Mat ReadDescriptors(Reader& reader) {
  const auto rows = static_cast<int>(reader.Count(32));
  if (rows == 0) return {};
  cv::Mat descriptors(rows, 32, CV_8U);
  reader.Bytes(descriptors.data, 32 * static_cast<std::size_t>(rows));
  return descriptors;
}

void WriteFeatures(Writer& writer, const FrameFeatures& features) {
  writer(static_cast<std::uint32_t>(features.points.size()));
  for (const PointFeature& point : features.points) Fields(writer, point);
  WriteDescriptors(writer, features.point_descriptors);
  writer(static_cast<std::uint32_t>(features.lines.size()));
  for (const LineFeature& line : features.lines) {
    Doubles(writer, line.segment.s);
    Doubles(writer, line.segment.e);
    writer(line.segment_C.has_value());
    if (line.segment_C) Fields(writer, *line.segment_C);
  }
  WriteDescriptors(writer, features.line_descriptors);
}

std::shared_ptr<FrameFeatures> ReadFeatures(Reader& reader, const PinholeCamera& camera) {
  auto features = std::make_shared<FrameFeatures>();
  std::vector<cv::KeyPoint> keypoints;
  for (std::uint32_t i = reader.Count(40); i > 0; --i) {
    PointFeature& point = features->points.emplace_back();
    Fields(reader, point);
    Check(reader, point);
    cv::KeyPoint keypoint(static_cast<float>(point.uv.x()), static_cast<float>(point.uv.y()), 1.0F);
    keypoint.octave = point.octave;
    keypoints.push_back(keypoint);
  }
  features->point_descriptors = ReadDescriptors(reader);
  features->point_grid = FeatureGrid(keypoints, {camera.width, camera.height});
  for (std::uint32_t i = reader.Count(17); i > 0; --i) {
    LineFeature& line = features->lines.emplace_back();
    Doubles(reader, line.segment.s);
    Doubles(reader, line.segment.e);
    bool has_depth = false;
    reader(has_depth);
    if (has_depth) Fields(reader, line.segment_C.emplace());
    Check(reader, line);
  }
  features->line_descriptors = ReadDescriptors(reader);
  const auto fits = [](const cv::Mat& descriptors, std::size_t count) {
    return descriptors.empty() || static_cast<std::size_t>(descriptors.rows) == count;
  };
  reader.Require(fits(features->point_descriptors, features->points.size()) &&
                     features->point_descriptors.empty() == features->points.empty() &&
                     fits(features->line_descriptors, features->lines.size()),
                 "there is not one descriptor a feature");
  return features;
}

// What a keyframe is held against where another map may show its place.
void WriteEvidence(Writer& writer, const KeyFrame& keyframe) {
  const cv::Mat& grid = keyframe.depth_grid;
  writer(keyframe.found);
  writer(static_cast<std::uint32_t>(grid.total()));
  for (int v = 0; v < grid.rows; ++v) {
    writer.Bytes(grid.ptr(v), sizeof(float) * static_cast<std::size_t>(grid.cols));
  }
}

// size: of the grid of depth, in cells.
double ReadEvidence(Reader& reader, const cv::Size& size, FrameFeatures& features) {
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

template <class Landmark>
void WriteLandmark(Writer& writer, const Landmark& landmark,
                   const std::unordered_map<KeyFrameId, std::int32_t>& ranks) {
  Fields(writer, landmark);
  writer(static_cast<std::uint32_t>(landmark.observations.size()));
  for (const Observation& o : landmark.observations) {
    writer(ranks.at(o.keyframe));
    writer(o.index);
  }
}

// Fills a landmark that the map made, and ties it to the keyframes that see it. slots: of the
// features of a keyframe; observe: of the map.
template <class Landmark, class Slots, class Observe>
void ReadLandmark(Reader& reader, Landmark& landmark, const Map& map, const Slots& slots,
                  const Observe& observe) {
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
                       static_cast<std::size_t>(o.index) < slots(*keyframe) &&
                       observe(o, landmark.id),
                   "a landmark is seen by what is not there, or twice");
  }
}

// Those that have keyframes, in their order; each is written by its rank.
std::map<SubmapId, std::int32_t> WriteSubmaps(Writer& writer, const Map& map) {
  std::map<SubmapId, std::int32_t> ranks;
  for (const KeyFrameId id : map.keyframe_ids()) ranks.emplace(map.keyframe(id)->submap, 0);
  std::int32_t next = 0;
  for (auto& [submap, rank] : ranks) rank = next++;
  writer(static_cast<std::uint32_t>(ranks.size()));
  for (const auto& [submap, rank] : ranks) {
    // The origin of a world is never removed, so that its root is among them.
    writer(ranks.at(map.Root(submap)));
    const auto& gravity_W = map.gravity_W(submap);
    writer(gravity_W.has_value());
    if (gravity_W) Doubles(writer, *gravity_W);
  }
  return ranks;
}

// Returns how many there are.
std::uint32_t ReadSubmaps(Reader& reader, Map& map) {
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

// The least that holds all of the map: so that older programs read what they can.
std::uint32_t VersionFor(const Map& map) {
  return map.point_kind().name == PointKind().name ? kFirstWithKind - 1 : kVersion;
}

std::string Encode(const PinholeCamera& camera, const Map& map) {
  Writer writer;
  Fields(writer, camera);
  if (VersionFor(map) >= kFirstWithKind) WriteKind(writer, map.point_kind());
  const std::map<SubmapId, std::int32_t> submaps = WriteSubmaps(writer, map);
  std::unordered_map<KeyFrameId, std::int32_t> ranks;
  writer(static_cast<std::uint32_t>(map.num_keyframes()));
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    ranks.emplace(id, static_cast<std::int32_t>(ranks.size()));
    writer(submaps.at(keyframe.submap));
    writer(keyframe.frame.index);
    writer(keyframe.frame.stamp);
    writer.Bytes(keyframe.T_WC.data(), sizeof(double) * Pose::kSize);
    WriteFeatures(writer, *keyframe.frame.features);
    WriteEvidence(writer, keyframe);
  }
  writer(static_cast<std::uint32_t>(map.num_points()));
  for (const PointId id : map.point_ids()) WriteLandmark(writer, *map.point(id), ranks);
  writer(static_cast<std::uint32_t>(map.num_lines()));
  for (const LineId id : map.line_ids()) WriteLandmark(writer, *map.line(id), ranks);
  return writer.content();
}

SavedMap Decode(Reader& reader, std::uint32_t version) {
  SavedMap saved;
  Fields(reader, saved.camera);
  Check(reader, saved.camera);
  Map& map = saved.map;
  if (version >= kFirstWithKind) map.SetPointKind(ReadKind(reader));
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
    std::array<double, Pose::kSize> block;
    reader.Bytes(block.data(), sizeof(block));
    const auto features = ReadFeatures(reader, saved.camera);
    const double found =
        version >= kFirstWithDepth ? ReadEvidence(reader, grid_size, *features) : 0.0;
    frame.features = features;
    map.AddKeyFrame(frame, CheckedPose(reader, block), submap).found = found;
  }
  for (const KeyFrameId id : map.keyframe_ids()) {
    reader.Require(populated[map.Root(map.keyframe(id)->submap).index()],
                   "a submap is joined with one that has no keyframe");
  }
  for (std::uint32_t i = reader.Count(100); i > 0; --i) {
    ReadLandmark(
        reader, map.AddPoint(Eigen::Vector3d::Zero(), 0), map,
        [](const KeyFrame& keyframe) { return keyframe.points.size(); },
        [&](const Observation& o, PointId id) {
          return map.ObservePoint(o.keyframe, o.index, id);
        });
  }
  for (std::uint32_t i = reader.Count(90); i > 0; --i) {
    ReadLandmark(
        reader, map.AddLine(Segment3(), 0), map,
        [](const KeyFrame& keyframe) { return keyframe.lines.size(); },
        [&](const Observation& o, LineId id) { return map.ObserveLine(o.keyframe, o.index, id); });
  }
  reader.RequireEnd();
  return saved;
}

}  // namespace

void SaveMap(const std::filesystem::path& path, const PinholeCamera& camera, const Map& map) {
  const std::string content = Encode(camera, map);
  Writer header;
  header.Bytes(kMagic.data(), kMagic.size());
  header(VersionFor(map));
  header(Crc32(std::as_bytes(std::span(content))));
  header(static_cast<std::uint64_t>(content.size()));
  AtomicFile file(path);
  file.stream() << header.content() << content;
  file.Commit();
}

SavedMap LoadMap(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw IoError(path, "cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) throw IoError(path, "cannot be read");
  if (bytes.compare(0, kMagic.size(), kMagic.data(), kMagic.size()) != 0) {
    throw IoError(path, "is no map of Highwall");
  }
  if (bytes.size() < kHeaderSize) throw IoError(path, "is cut short");
  Reader header(path, bytes.data() + kMagic.size(), kHeaderSize - kMagic.size());
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
  Reader reader(path, content, size);
  try {
    return Decode(reader, version);
  } catch (const InvalidArgument& e) {  // the camera, the kind of its points
    throw IoError(path, std::string("is damaged: ") + e.what());
  }
}

}  // namespace highwall
