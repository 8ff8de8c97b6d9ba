#include "local/corner_refiner.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/LU>

#include "local/corner_patch.h"

namespace highwall {
namespace {

constexpr double kStep = 4.0;           // [px] of the differences that the warp is made of
constexpr double kMinDepth = 0.05;      // [m] nearer nothing is projected
constexpr double kMinDeterminant = .1;  // of the warp: seen smaller than that it shows no corner

// From offsets [px] in the image of C to offsets in that of R, of a surface about p_R that faces R.
std::optional<Eigen::Matrix2d> Warp(const PinholeCamera& camera, const Eigen::Vector3d& p_R,
                                    const Pose& T_CR) {
  const auto image = [&](const Eigen::Vector3d& p_C) {
    return Eigen::Vector2d(camera.fx * p_C.x() / p_C.z(), camera.fy * p_C.y() / p_C.z());
  };
  const double side = kStep * p_R.z();
  const Eigen::Vector3d p_C = T_CR * p_R;
  const Eigen::Vector3d right_C = T_CR * (p_R + Eigen::Vector3d(side / camera.fx, 0.0, 0.0));
  const Eigen::Vector3d below_C = T_CR * (p_R + Eigen::Vector3d(0.0, side / camera.fy, 0.0));
  if (!(p_R.z() > kMinDepth && p_C.z() > kMinDepth && right_C.z() > kMinDepth &&
        below_C.z() > kMinDepth)) {
    return std::nullopt;
  }
  Eigen::Matrix2d A_CR;
  A_CR << image(right_C) - image(p_C), image(below_C) - image(p_C);
  A_CR /= kStep;
  if (!(A_CR.determinant() > kMinDeterminant)) return std::nullopt;
  return A_CR.inverse().eval();
}

}  // namespace

std::shared_ptr<const FrameFeatures> CornerRefiner::Refine(const TrackedFrame& tracked,
                                                           const ImageLevels& image,
                                                           const Map& map) const {
  auto refined = std::make_shared<FrameFeatures>(*tracked.frame.features);
  refined->gray.release();
  const Pose T_CW = tracked.T_WC.Inverse();
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    const MapPoint* point = map.point(tracked.points[i]);
    if (point == nullptr || point->patch == nullptr) continue;
    const KeyFrameId reference = point->patch->keyframe;
    if (map.RootOf(reference) != map.Root(tracked.submap)) continue;
    const Pose T_WR = map.ResolvePose(reference);
    const auto A = Warp(camera_, T_WR.Inverse() * point->p_W, T_CW * T_WR);
    if (!A) continue;
    PointFeature& feature = refined->points[i];
    const Eigen::Vector2d pixel = feature.pixel.cast<double>();
    const auto found = AlignPatch(*point->patch, *A, image, feature.octave, pixel);
    if (!found) continue;
    feature.uv += camera_.UndistortPixel(*found) - camera_.UndistortPixel(pixel);
    feature.pixel = found->cast<float>();
  }
  return refined;
}

void CornerRefiner::Remember(const KeyFrame& keyframe, const ImageLevels& image, Map* map) const {
  for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
    MapPoint* point = map->point(keyframe.points[i]);
    if (point == nullptr || point->patch != nullptr) continue;
    const PointFeature& feature = keyframe.frame.features->points[i];
    const auto patch = CutPatch(image, feature.octave, feature.pixel.cast<double>(), keyframe.id);
    if (patch) point->patch = std::make_shared<const CornerPatch>(*patch);
  }
}

}  // namespace highwall
