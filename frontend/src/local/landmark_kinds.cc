#include "local/landmark_kinds.h"

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/pose/pose_solver.h>

#include "local/depthless_landmarks.h"

namespace highwall {
namespace {

// Relative to its depth: a less certain corner creates no landmark.
constexpr double kMaxDepthSigma = 0.03;
constexpr double kMinLineLength = 1e-3;  // [m] a shorter segment has no valid direction

}  // namespace

std::optional<Eigen::Vector3d> FromDepth(const PointFeature& feature, const PinholeCamera& camera,
                                         double) {
  if (!HasSoundDepth(feature, kMaxDepthSigma)) return std::nullopt;
  return camera.Unproject(feature.uv, feature.depth);
}

std::optional<Segment3> FromDepth(const LineFeature& feature, const PinholeCamera&,
                                  double min_line_length) {
  if (!feature.segment_C) return std::nullopt;
  const Segment3 segment_C(feature.segment_C->p_C, feature.segment_C->q_C);
  if (segment_C.Length() < min_line_length) return std::nullopt;
  return segment_C;
}

void TakeDescriptor(const FrameFeatures& features, int index, MapLine* line) {
  if (features.line_descriptors.empty()) return;
  line->descriptor = DescriptorRow(features.line_descriptors, index);
  line->has_descriptor = true;
}

bool MoveTo(const Eigen::Vector3d& p_W, MapPoint* point) {
  point->p_W = p_W;
  return true;
}

bool MoveTo(const OrthonormalLine& line_W, MapLine* line) {
  line->segment_W = TrimTo(line_W.Plucker(), line->segment_W);
  // A line that has rotated across its old ends has no length between them.
  return line->segment_W.Length() >= kMinLineLength;
}

bool IsInDomain(const Eigen::Vector3d& p_W, const PointFeature&, const Pose& T_CW,
                const RgbdProjection& projection) {
  const Eigen::Vector3d p_C = T_CW * p_W;
  return p_C.z() >= projection.min_depth();
}

bool IsInDomain(const OrthonormalLine& line_W, const LineFeature& feature, const Pose& T_CW,
                const RgbdProjection& projection) {
  const PluckerLine line_C = T_CW * line_W.Plucker();
  return TrimToObservation(line_C, feature.segment.s.cast<double>(),
                           feature.segment.e.cast<double>(), projection)
      .has_value();
}

}  // namespace highwall
