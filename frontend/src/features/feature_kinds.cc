#include "features/feature_kinds.h"

namespace highwall {
namespace {

constexpr double kNear = 0.01;  // [m] a point that would come nearer stays where it is

}  // namespace

std::array<Eigen::Vector2d, 3> PixelsOf(const LineFeature& line) {
  const Eigen::Vector2d s = line.segment.s.cast<double>(), e = line.segment.e.cast<double>();
  return {s, e, 0.5 * (s + e)};
}

double DepthFactor::At(const Eigen::Vector3d& p_C) const {
  const Eigen::Vector2d raw = camera_.Project(p_C);
  const double off = pattern_.At(raw.x(), raw.y(), camera_.width, camera_.height);
  const double rest = 1.0 - p_C.z() * off;
  return rest > 0.0 ? 1.0 / rest : 1.0;
}

void CorrectDepth(const DepthFactor& factor, PointFeature* point) {
  if (!HasDepth(*point)) return;
  point->depth *= factor.At(factor.undistorted().Unproject(point->uv, point->depth));
}

void CorrectDepth(const DepthFactor& factor, LineFeature* line) {
  if (!HasDepth(*line)) return;
  line->segment_C->p_C *= factor.At(line->segment_C->p_C);
  line->segment_C->q_C *= factor.At(line->segment_C->q_C);
}

void MoveFeature(const MovePoint& move, const PinholeCamera& camera, double mean_depth,
                 PointFeature* point) {
  const bool measured = HasDepth(*point);
  const Eigen::Vector3d p_C =
      move(point->uv, camera.Unproject(point->uv, measured ? point->depth : mean_depth), measured);
  if (!(p_C.z() >= kNear)) return;
  point->uv = camera.Project(p_C);
  if (measured) point->depth = p_C.z();
}

void MoveFeature(const MovePoint& move, const PinholeCamera& camera, double mean_depth,
                 LineFeature* line) {
  const auto move_end = [&](Eigen::Vector2f* end, Eigen::Vector3d* measured) {
    const Eigen::Vector2d uv = end->cast<double>();
    const Eigen::Vector3d p_C =
        move(uv, measured ? *measured : camera.Unproject(uv, mean_depth), measured != nullptr);
    if (p_C.z() < kNear) return;
    *end = camera.Project(p_C).cast<float>();
    if (measured) *measured = p_C;
  };
  move_end(&line->segment.s, line->segment_C ? &line->segment_C->p_C : nullptr);
  move_end(&line->segment.e, line->segment_C ? &line->segment_C->q_C : nullptr);
}

std::optional<Eigen::Vector3d> ShiftOf(const PointFeature& before, const PointFeature& after,
                                       const PinholeCamera& camera) {
  if (!HasDepth(before)) return std::nullopt;
  return Eigen::Vector3d(camera.Unproject(after.uv, after.depth) -
                         camera.Unproject(before.uv, before.depth));
}

std::optional<Eigen::Vector3d> ShiftOf(const LineFeature& before, const LineFeature& after,
                                       const PinholeCamera&) {
  const auto &from = before.segment_C, &to = after.segment_C;
  if (!from || !to) return std::nullopt;
  return Eigen::Vector3d(0.5 * (to->p_C - from->p_C + to->q_C - from->q_C));
}

}  // namespace highwall
