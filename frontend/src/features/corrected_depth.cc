#include "features/corrected_depth.h"

#include <Eigen/Core>

namespace highwall {

std::shared_ptr<const FrameFeatures> CorrectedDepth(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthPattern& pattern) {
  // Correction factor of the distance in a direction of the camera.
  const auto factor = [&](const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d raw = camera.Project(p_C);
    const double off = pattern.At(raw.x(), raw.y(), camera.width, camera.height);
    const double rest = 1.0 - p_C.z() * off;
    return rest > 0.0 ? 1.0 / rest : 1.0;
  };
  auto corrected = std::make_shared<FrameFeatures>(features);
  const PinholeCamera undistorted = camera.WithoutDistortion();
  for (PointFeature& point : corrected->points) {
    if (point.depth > 0.0) point.depth *= factor(undistorted.Unproject(point.uv, point.depth));
  }
  for (LineFeature& line : corrected->lines) {
    if (!line.segment_C) continue;
    line.segment_C->p_C *= factor(line.segment_C->p_C);
    line.segment_C->q_C *= factor(line.segment_C->q_C);
  }
  return corrected;
}

}  // namespace highwall
