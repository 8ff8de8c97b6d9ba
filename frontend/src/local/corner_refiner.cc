#include "local/corner_refiner.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/LU>

#include "local/corner_patch.h"

namespace highwall {
namespace {

constexpr double kStep = 4.0;           // [px] of the finite differences of the warp
constexpr double kMinDepth = 0.05;      // [m] nearer points are not projected
constexpr double kMinDeterminant = .1;  // of the warp: a corner scaled down further is invisible
// Tangent of half the angle that a patch may span, the coarsest level but two of a typical camera:
// over a larger angle a surface is rarely fronto-parallel, or even a single one.
constexpr double kWidest = 0.0215;

// Returns the warp from offsets [px] in the image of C to offsets in that of R, for a surface at
// p_R fronto-parallel to R.
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
    const MapPoint* point = map.Find(tracked.points[i]);
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
    feature.noise.px = feature.refined_noise_px;
    feature.refined = true;
  }
  refined->point_grid = GridOf(refined->points, {camera_.width, camera_.height});
  return refined;
}

bool CornerRefiner::LiesOnOneSurface(const cv::Mat& depth_grid, const Eigen::Vector2d& uv,
                                     double radius, double z) const {
  constexpr double kSmooth = 0.05;  // of the depth: a larger step is an edge
  if (depth_grid.empty()) return true;
  const cv::Point first = grid_.CellOf(uv.array() - radius),
                  last = grid_.CellOf(uv.array() + radius);
  for (int v = first.y; v <= last.y; ++v) {
    for (int u = first.x; u <= last.x; ++u) {
      const auto reading = static_cast<double>(depth_grid.at<float>(v, u));
      if (reading > 0.0 && std::abs(reading - z) > kSmooth * z) return false;
    }
  }
  return true;
}

void CornerRefiner::Remember(const KeyFrame& keyframe, const ImageLevels& image, Map* map) const {
  const FrameFeatures& features = *keyframe.frame.features;
  const Pose T_CW = keyframe.T_WC.Inverse();
  for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
    MapPoint* point = map->Find(keyframe.points[i]);
    if (point == nullptr || point->patch != nullptr) continue;
    const PointFeature& feature = features.points[i];
    const double radius = CornerPatch::kCompared * image.Scale(feature.octave);
    if (radius > kWidest * camera_.fx) continue;
    const double z = (T_CW * point->p_W).z();
    if (!LiesOnOneSurface(features.depth_grid, feature.uv, radius, z)) continue;
    const auto patch = CutPatch(image, feature.octave, feature.pixel.cast<double>(), keyframe.id);
    if (patch) point->patch = std::make_shared<const CornerPatch>(*patch);
  }
}

}  // namespace highwall
