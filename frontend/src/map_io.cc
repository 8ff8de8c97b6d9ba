#include <highwall/frontend/map_io.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include <opencv2/core/types.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

namespace highwall {
namespace {

static_assert(std::endian::native == std::endian::little, "map files are little-endian");

constexpr std::array<char, 8> kMagic = {'H', 'W', 'M', 'A', 'P', '\r', '\n', '\x1a'};
constexpr std::uint32_t kVersion = 1;
// Magic, version, CRC-32 of the content, bytes of the content.
constexpr std::size_t kHeaderSize = 8 + 4 + 4 + 8;

// CRC-32 as of Ethernet and zip (polynomial 0x04C11DB7, reflected).
std::uint32_t Crc32(const char* data, std::size_t size) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1) : c >> 1;
      table[i] = c;
    }
    return table;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < size; ++i) {
    crc = kTable[(crc ^ static_cast<unsigned char>(data[i])) & 0xFFU] ^ (crc >> 8);
  }
  return ~crc;
}

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
  void Bytes(void* data, std::size_t size) {
    Require(size <= static_cast<std::size_t>(end_ - data_));
    std::memcpy(data, data_, size);
    data_ += size;
  }
  // Of things that take at least `bytes` each.
  std::uint32_t Count(std::size_t bytes) {
    std::uint32_t count = 0;
    (*this)(count);
    Require(count <= static_cast<std::size_t>(end_ - data_) / bytes);
    return count;
  }
  void RequireEnd() const { Require(data_ == end_); }
  void Require(bool condition) const {
    if (!condition) throw IoError(path_, "is damaged: its content contradicts itself");
  }

 private:
  const std::filesystem::path& path_;
  const char* data_;
  const char* end_;
};

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

std::shared_ptr<const FrameFeatures> ReadFeatures(Reader& reader, const PinholeCamera& camera) {
  auto features = std::make_shared<FrameFeatures>();
  std::vector<cv::KeyPoint> keypoints;
  for (std::uint32_t i = reader.Count(40); i > 0; --i) {
    PointFeature& point = features->points.emplace_back();
    Fields(reader, point);
    reader.Require(point.uv.allFinite());
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
  }
  features->line_descriptors = ReadDescriptors(reader);
  const auto fits = [](const cv::Mat& descriptors, std::size_t count) {
    return descriptors.empty() || static_cast<std::size_t>(descriptors.rows) == count;
  };
  reader.Require(fits(features->point_descriptors, features->points.size()) &&
                 features->point_descriptors.empty() == features->points.empty() &&
                 fits(features->line_descriptors, features->lines.size()));
  return features;
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
  const std::uint32_t observations = reader.Count(8);
  reader.Require(observations > 0);
  for (std::uint32_t i = 0; i < observations; ++i) {
    Observation o;
    reader(o.keyframe);
    reader(o.index);
    const KeyFrame* keyframe = map.keyframe(o.keyframe);
    reader.Require(keyframe != nullptr && o.index >= 0 &&
                   static_cast<std::size_t>(o.index) < slots(*keyframe) && observe(o, landmark.id));
  }
}

std::string Encode(const PinholeCamera& camera, const Map& map) {
  Writer writer;
  Fields(writer, camera);
  std::unordered_map<KeyFrameId, std::int32_t> ranks;
  writer(static_cast<std::uint32_t>(map.num_keyframes()));
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame& keyframe = *map.keyframe(id);
    ranks.emplace(id, static_cast<std::int32_t>(ranks.size()));
    writer(keyframe.frame.index);
    writer(keyframe.frame.stamp);
    writer.Bytes(keyframe.T_WC.data(), sizeof(double) * Pose::kSize);
    WriteFeatures(writer, *keyframe.frame.features);
  }
  writer(static_cast<std::uint32_t>(map.num_points()));
  for (const PointId id : map.point_ids()) WriteLandmark(writer, *map.point(id), ranks);
  writer(static_cast<std::uint32_t>(map.num_lines()));
  for (const LineId id : map.line_ids()) WriteLandmark(writer, *map.line(id), ranks);
  return writer.content();
}

SavedMap Decode(Reader& reader) {
  SavedMap saved;
  Fields(reader, saved.camera);
  reader.Require(saved.camera.width > 0 && saved.camera.height > 0);
  Map& map = saved.map;
  for (std::uint32_t i = reader.Count(72); i > 0; --i) {
    Frame frame;
    reader(frame.index);
    reader(frame.stamp);
    std::array<double, Pose::kSize> block;
    reader.Bytes(block.data(), sizeof(block));
    frame.features = ReadFeatures(reader, saved.camera);
    map.AddKeyFrame(frame, Pose::FromBlock(block.data()));
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
  header(kVersion);
  header(Crc32(content.data(), content.size()));
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
  if (version != kVersion) {
    throw IoError(path, "is a map of version " + std::to_string(version) + ", not " +
                            std::to_string(kVersion) + ": make it again");
  }
  const char* const content = bytes.data() + kHeaderSize;
  if (bytes.size() - kHeaderSize < size) throw IoError(path, "is cut short");
  if (bytes.size() - kHeaderSize > size || Crc32(content, size) != crc) {
    throw IoError(path, "is damaged: its checksum does not fit");
  }
  Reader reader(path, content, size);
  try {
    return Decode(reader);
  } catch (const InvalidArgument&) {  // a pose or a position that is none
    reader.Require(false);
    throw;
  }
}

}  // namespace highwall
