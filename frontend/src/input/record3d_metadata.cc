#include "input/record3d_metadata.h"

#include <cmath>
#include <cstddef>
#include <string>

#include <highwall/core/error.h>

#include "input/foreign_map.h"
#include "input/matrix_text.h"
#include "input/phone_recording.h"

namespace highwall {
namespace {

std::vector<std::optional<Pose>> ReadRecord3dPoses(const ForeignMap& json) {
  std::vector<std::optional<Pose>> poses;
  for (const std::vector<double>& v : json.Rows("poses", 7)) {
    const Eigen::Quaterniond q(v[3], v[0], v[1], v[2]);
    std::optional<Pose>& pose = poses.emplace_back();
    if (q.norm() > 1e-6 && std::isfinite(q.norm())) pose = FromArkit(Pose(q, {v[4], v[5], v[6]}));
  }
  return poses;
}

void RequireOneLength(const std::filesystem::path& path, const Record3dMetadata& metadata) {
  const std::size_t stamps = metadata.stamps.size();
  for (const auto& [name, count] : {std::pair("poses", metadata.poses.size()),
                                    {"perFrameIntrinsicCoeffs", metadata.cameras.size()}}) {
    if (stamps == 0 || count == 0 || count == stamps) continue;
    throw IoError(path, "has " + std::to_string(count) + " " + name + ", but " +
                            std::to_string(stamps) + " frameTimestamps");
  }
}

}  // namespace

Record3dMetadata ReadRecord3dMetadata(const std::filesystem::path& path) {
  const ForeignMap json = ForeignMap::LoadJson(path);
  Record3dMetadata metadata;
  metadata.camera = CameraOfMatrix(path, json.Numbers("K", 9));
  metadata.camera.width = json.Integer("w");
  metadata.camera.height = json.Integer("h");
  if (metadata.camera.width < 1 || metadata.camera.height < 1) {
    throw IoError(path, "w and h must be positive");
  }
  if (json.Has("frameTimestamps")) metadata.stamps = json.SecondsList("frameTimestamps");
  if (json.Has("fps")) metadata.rate = json.Number("fps");
  if (!(metadata.rate > 0.0)) throw IoError(path, "fps must be positive");
  if (json.Has("poses")) metadata.poses = ReadRecord3dPoses(json);
  if (json.Has("perFrameIntrinsicCoeffs")) {
    for (const std::vector<double>& v : json.Rows("perFrameIntrinsicCoeffs", 4)) {
      PinholeCamera& camera = metadata.cameras.emplace_back(metadata.camera);
      if (!(v[0] > 0.0) || !(v[1] > 0.0)) throw IoError(path, "a focal length is not positive");
      camera.fx = v[0];
      camera.fy = v[1];
      camera.cx = v[2];
      camera.cy = v[3];
    }
  }
  RequireOneLength(path, metadata);
  return metadata;
}

}  // namespace highwall
