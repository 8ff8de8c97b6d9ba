#include "sensor/noise_estimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/frontend/pose/pose_observations.h>
#include <highwall/internal/median.h>

#include "sensor/feature_noise.h"

namespace highwall {
namespace {

constexpr double kRemembered = 0.7;  // of the previous weight, at each update
// Weight, in observations, of the group's mean in each of its kinds, and of the a priori noise in
// each group.
constexpr double kPrior = 100.0;
constexpr std::size_t kMinRows = 8;   // of a kind, for a median
constexpr std::size_t kMinViews = 3;  // of a landmark, for its residuals to be informative
// Errors common to all views of a landmark appear in none of their residuals: the remaining
// calibration error of a camera [px], in images of the usual side, and distortion and bias of
// depth, half of its variance.
constexpr double kSharedPixels = 0.4, kSharedDepth = 0.7;
constexpr double kUsualSide = 640.0;  // [px] the longer one
constexpr double kMaxFactor = 10.0;   // a larger factor means that the model is wrong

// Medians of chi-square with 1 and 2 degrees of freedom.
double Median(int dof) {
  return dof == 1 ? 0.4549364 : 1.3862944;
}

// Returns the calibration error [px] in images of a camera. In larger images than usual it is not
// known to be larger.
double SharedPixels(const PinholeCamera& camera) {
  const auto side = static_cast<double>(std::max(camera.width, camera.height));
  return kSharedPixels * std::min(1.0, side / kUsualSide);
}

// Expected ratio of the squared residual of a landmark to its variance, below 1 because the
// landmark is fitted to it.
double Redundancy(std::size_t views) {
  const auto n = static_cast<double>(views);
  return (n - 1.0) / n;
}

}  // namespace

NoiseEstimator::NoiseEstimator(const MeasurementModel& model) : model_(model) {
  const double shared = SharedPixels(model.camera());
  const auto of_point = [&](int octave) { return shared / model.PointSigma(octave); };
  const auto of_line = [&](int) { return shared / model.options().line_sigma; };
  const auto of_depth = [](int) { return kSharedDepth; };
  Follow(kPointPx, 2, &estimate_.point_px, of_point);
  Follow(kLowContrastPx, 2, &estimate_.low_contrast_px, of_point);
  Follow(kRefinedPx, 2, &estimate_.refined_px, of_point);
  Follow(kPointDepth, 1, &estimate_.point_depth, of_depth);
  Follow(kEdgeDepth, 1, &estimate_.edge_depth, of_depth);
  Follow(kLinePx, 2, &estimate_.line_px, of_line);
  Follow(kLineDepth, 2, &estimate_.line_depth, of_depth);
}

template <std::size_t kSize, class Shared>
void NoiseEstimator::Follow(GroupId group, int dof, std::array<double, kSize>* factors,
                            const Shared& shared) {
  groups_[group].dof = dof;
  for (std::size_t i = 0; i < kSize; ++i) {
    Kind kind{.factor = &(*factors)[i], .shared = shared(static_cast<int>(i)), .squared = {}};
    *kind.factor = std::hypot(1.0, kind.shared);
    groups_[group].kinds.push_back(std::move(kind));
  }
}

std::shared_ptr<const FrameFeatures> NoiseEstimator::Apply(const FrameFeatures& features) const {
  return WithNoise(features, estimate_, model_);
}

void NoiseEstimator::Collect(const PointFeature& feature, const MapPoint& point, const Pose& T_WC) {
  if (!(feature.depth > 0.0)) return;  // a view with fewer rows than the landmark has unknowns
  Eigen::Vector3d r;
  if (!model_.projection().Evaluate<3>(RgbdProjection::At(T_WC.data()), model_.Rows(feature),
                                       point.p_W, &r, nullptr, nullptr)) {
    return;
  }
  const double redundancy = Redundancy(point.observations.size());
  const auto square = [&](double factor) { return factor * factor / redundancy; };
  Group& px = groups_[feature.refined        ? kRefinedPx
                      : feature.low_contrast ? kLowContrastPx
                                             : kPointPx];
  px.kinds[static_cast<std::size_t>(feature.octave)].squared.push_back(square(feature.noise.px) *
                                                                       r.head<2>().squaredNorm());
  Group& depth = groups_[IsAtEdge(feature, model_) ? kEdgeDepth : kPointDepth];
  depth.kinds[DepthBand(feature.depth)].squared.push_back(square(feature.noise.depth) * r.z() *
                                                          r.z());
}

void NoiseEstimator::Collect(const LineFeature& feature, const MapLine& line, const Pose& T_WC) {
  if (!feature.segment_C) return;
  const auto seen = MakePoseObservation(model_, line, feature, T_WC);
  if (!seen) return;
  const auto view = RgbdProjection::At(T_WC.data());
  Eigen::Vector2d p, q;
  if (!model_.projection().Evaluate<2>(view, seen->rows[0], seen->segment_W.p(), &p, nullptr,
                                       nullptr) ||
      !model_.projection().Evaluate<2>(view, seen->rows[1], seen->segment_W.q(), &q, nullptr,
                                       nullptr)) {
    return;
  }
  const double redundancy = Redundancy(line.observations.size());
  const auto square = [&](double factor) { return factor * factor / redundancy; };
  groups_[kLinePx].kinds[LengthBand(feature, model_)].squared.push_back(
      square(feature.noise.px) * Eigen::Vector2d(p[0], q[0]).squaredNorm());
  const double z = 0.5 * (feature.segment_C->p_C.z() + feature.segment_C->q_C.z());
  groups_[kLineDepth].kinds[DepthBand(z)].squared.push_back(
      square(feature.noise.depth) * Eigen::Vector2d(p[1], q[1]).squaredNorm());
}

void NoiseEstimator::Update(Group* group) {
  double sum = 0.0, weight = kPrior;
  for (Kind& kind : group->kinds) {
    kind.weight *= kRemembered;
    if (kind.squared.size() >= kMinRows) {
      const auto rows = static_cast<double>(kind.squared.size());
      const double median = UpperMedian(std::move(kind.squared));
      if (median > 0.0) {
        kind.log_var = (kind.weight * kind.log_var + rows * std::log(median / Median(group->dof))) /
                       (kind.weight + rows);
        kind.weight += rows;
      }
    }
    kind.squared.clear();
    sum += kind.weight * kind.log_var;
    weight += kind.weight;
  }
  const double of_group = sum / weight;
  for (const Kind& kind : group->kinds) {
    const double log_var =
        (kind.weight * kind.log_var + kPrior * of_group) / (kind.weight + kPrior);
    *kind.factor = std::min(std::hypot(std::exp(0.5 * log_var), kind.shared), kMaxFactor);
  }
}

void NoiseEstimator::Add(const Map& map, std::span<const KeyFrameId> keyframes) {
  for (const KeyFrameId id : keyframes) {
    const KeyFrame& keyframe = *map.keyframe(id);
    const FrameFeatures& features = *keyframe.frame.features;
    ForEachKind([&]<class Landmark>() {
      const LandmarkIds<Landmark>& ids = PartOf<Landmark>(keyframe);
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const Landmark* const landmark = map.Find(ids[i]);
        if (landmark == nullptr || landmark->observations.size() < kMinViews) continue;
        Collect(PartOf<Landmark>(features)[i], *landmark, keyframe.T_WC);
      }
    });
  }
  for (Group& group : groups_) Update(&group);
}

}  // namespace highwall
