#include "tracking/relocalizer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/frontend/map/keyframe_index.h>
#include <highwall/frontend/pose/pose_solver.h>

#include "pose/support.h"

namespace highwall {
namespace {

constexpr int kSampleSize = 3;
constexpr std::uint32_t kSeed = 1;
constexpr int kCandidates = 5;        // keyframes verified, most similar first
constexpr double kDistinctive = 0.8;  // best against second best

// Putative match of a map point and a feature.
struct Pair {
  int feature = 0;
  PointId point = kNoId;
  Eigen::Vector3d p_W;
  std::optional<Eigen::Vector3d> p_C;  // from the feature's depth
};

// Putative match of a map line and a feature.
struct LinePair {
  int feature = 0;
  const MapLine* line = nullptr;
  const LineFeature* seen = nullptr;
};

// Matches lines of the frame with lines of the keyframe by their descriptors.
std::vector<LinePair> PairLines(const FrameFeatures& features, const Map& map,
                                const KeyFrame& keyframe, const LineMatcherOptions& options) {
  const FrameFeatures& seen = *keyframe.frame.features;
  if (features.line_descriptors.empty() || seen.line_descriptors.empty()) return {};
  const auto as_features = [](const FrameFeatures& frame) {
    LineFeatures lines{{}, frame.line_descriptors};
    for (const LineFeature& line : frame.lines) lines.segments.push_back(line.segment);
    return lines;
  };
  std::vector<LinePair> pairs;
  for (const FeatureMatch& match :
       MatchLargeMotion(as_features(features), as_features(seen), options)) {
    const MapLine* line = map.Find(keyframe.lines[static_cast<std::size_t>(match.train)]);
    if (line == nullptr) continue;
    pairs.push_back({match.query, line, &features.lines[static_cast<std::size_t>(match.query)]});
  }
  return pairs;
}

// Returns the rigid transform from three p_C to their p_W; empty for a thin triangle, or if the
// triangles are not congruent.
std::optional<Pose> PoseFromTriangle(const std::array<const Pair*, kSampleSize>& sample) {
  Eigen::Matrix3d C, W;
  for (int i = 0; i < kSampleSize; ++i) {
    C.col(i) = *sample[static_cast<std::size_t>(i)]->p_C;
    W.col(i) = sample[static_cast<std::size_t>(i)]->p_W;
  }
  for (int i = 0; i < kSampleSize; ++i) {
    const int j = (i + 1) % kSampleSize;
    const double in_C = (C.col(i) - C.col(j)).norm(), in_W = (W.col(i) - W.col(j)).norm();
    if (in_C < 0.05 || std::abs(in_C - in_W) > 0.1 * in_C) return std::nullopt;
  }
  const double twice_area = (C.col(1) - C.col(0)).cross(C.col(2) - C.col(0)).norm();
  if (twice_area < 0.005) return std::nullopt;
  return Pose::FromMatrix(Eigen::umeyama(C, W, false));
}

// A pose from three readings is rough: residuals within three times the sigma are inliers.
constexpr double kRough = 9.0;

bool FitsPoint(const RgbdProjection::View& view, const PosePoint& point,
               const RgbdProjection& projection) {
  Eigen::Vector3d r;
  return projection.Evaluate<3>(view, point.rows, point.p_W, &r, nullptr, nullptr) &&
         r.squaredNorm() <= kRough * InlierBounds().Of(3);
}

bool FitsLine(const RgbdProjection::View& view, const PoseLine& line,
              const RgbdProjection& projection) {
  Eigen::Vector2d p, q;
  return projection.Evaluate<2>(view, line.rows[0], line.segment_W.p(), &p, nullptr, nullptr) &&
         projection.Evaluate<2>(view, line.rows[1], line.segment_W.q(), &q, nullptr, nullptr) &&
         p.squaredNorm() + q.squaredNorm() <= kRough * InlierBounds().Of(4);
}

int CountInliers(const Pose& T_WC, const std::vector<PosePoint>& points,
                 const RgbdProjection& projection) {
  const RgbdProjection::View view = RgbdProjection::At(T_WC.data());
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const PosePoint& point) {
    return FitsPoint(view, point, projection);
  }));
}

// Counts the inlier lines, each as it is seen from T_WC.
int CountInliers(const Pose& T_WC, const std::vector<LinePair>& lines,
                 const MeasurementModel& model) {
  const RgbdProjection::View view = RgbdProjection::At(T_WC.data());
  return static_cast<int>(std::count_if(lines.begin(), lines.end(), [&](const LinePair& pair) {
    const auto line = MakePoseObservation(model, *pair.line, *pair.seen, T_WC);
    return line && FitsLine(view, *line, model.projection());
  }));
}

// Returns the pose from three pairs with the most inliers, a line counting as two; empty if there
// are fewer than min_inliers. points[i] belongs to pairs[i].
std::optional<Pose> RansacPose(const std::vector<Pair>& pairs, const std::vector<PosePoint>& points,
                               const std::vector<LinePair>& lines, const MeasurementModel& model,
                               const RelocalizerOptions& options) {
  std::vector<const Pair*> with_depth;
  for (const Pair& pair : pairs) {
    if (pair.p_C) with_depth.push_back(&pair);
  }
  if (static_cast<int>(with_depth.size()) < kSampleSize) return std::nullopt;
  std::mt19937 rng(kSeed);
  std::optional<Pose> best;
  int best_inliers = options.min_inliers - 1;
  for (int iteration = 0; iteration < options.ransac_iterations; ++iteration) {
    std::array<const Pair*, kSampleSize> sample;
    for (const Pair*& s : sample) s = with_depth[rng() % with_depth.size()];
    const auto T_WC = PoseFromTriangle(sample);
    if (!T_WC) continue;
    const int inliers =
        Support(CountInliers(*T_WC, points, model.projection()), CountInliers(*T_WC, lines, model));
    if (inliers > best_inliers) {
      best_inliers = inliers;
      best = T_WC;
    }
  }
  return best;
}

// Pairs selected for one pose, with their matches.
struct Selection : PerKind<PoseObservations> {
  PerKind<LandmarkMatches> matches;
};

// Adds the lines as they are seen from T_WC.
void SelectLines(const std::vector<LinePair>& pairs, const Pose& T_WC,
                 const MeasurementModel& model, bool fitting_only, Selection* selection) {
  const RgbdProjection::View view = RgbdProjection::At(T_WC.data());
  for (const LinePair& pair : pairs) {
    const auto line = MakePoseObservation(model, *pair.line, *pair.seen, T_WC);
    if (!line || (fitting_only && !FitsLine(view, *line, model.projection()))) continue;
    selection->lines.push_back(*line);
    selection->matches.lines.emplace_back(pair.feature, pair.line->id);
  }
}

std::optional<Relocalization> Solve(const MeasurementModel& model, const Pose& T_WC,
                                    const Selection& selection, KeyFrameId keyframe,
                                    const PoseSolverOptions& solver) {
  const auto solution = SolvePose(T_WC, model.projection(), selection, solver);
  if (!solution) return std::nullopt;
  Relocalization result{solution->T_WC, keyframe, {}};
  ForEachKind([&]<class Landmark>() {
    const LandmarkMatches<Landmark>& matches = PartOf<Landmark>(selection.matches);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (PartOf<Landmark>(solution->inliers)[i]) {
        PartOf<Landmark>(result.matches).push_back(matches[i]);
      }
    }
  });
  return result;
}

// Refines the pose from the pairs that are inliers of a rough one, twice: the better pose selects
// the inliers better. All pairs would not do: outliers are off by up to a thousand sigma and
// outweigh the inliers however robust the cost. points[i] belongs to pairs[i].
std::optional<Relocalization> Refine(const MeasurementModel& model, const Pose& rough,
                                     const std::vector<Pair>& pairs,
                                     const std::vector<PosePoint>& points,
                                     const std::vector<LinePair>& lines, KeyFrameId keyframe,
                                     const PoseSolverOptions& solver) {
  constexpr int kRounds = 2;
  std::optional<Relocalization> result;
  Pose T_WC = rough;
  for (int round = 0; round < kRounds; ++round) {
    const RgbdProjection::View view = RgbdProjection::At(T_WC.data());
    Selection selection;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!FitsPoint(view, points[i], model.projection())) continue;
      selection.points.push_back(points[i]);
      selection.matches.points.emplace_back(pairs[i].feature, pairs[i].point);
    }
    SelectLines(lines, T_WC, model, true, &selection);
    result = Solve(model, T_WC, selection, keyframe, solver);
    if (!result) return std::nullopt;
    T_WC = result->T_WC;
  }
  return result;
}

}  // namespace

Relocalizer::Relocalizer(const MeasurementModel& model, const RelocalizerOptions& options)
    : model_(model), options_(options) {}

std::optional<Relocalization> Relocalizer::Relocalize(const FrameFeatures& features,
                                                      const Map& map) const {
  int verified = 0;
  for (const auto& [id, score] : map.index().Query(features)) {
    if (verified++ == kCandidates) break;
    if (auto found = MatchKeyFrame(features, map, id, map.keyframe(id)->T_WC)) return found;
  }
  return std::nullopt;
}

std::optional<Relocalization> Relocalizer::MatchKeyFrame(const FrameFeatures& features,
                                                         const Map& map, KeyFrameId id,
                                                         const Pose& guess) const {
  const KeyFrame& keyframe = *map.keyframe(id);
  if (auto found = MatchPoints(features, map, keyframe)) return found;
  return MatchLines(features, map, keyframe, guess);
}

std::optional<Relocalization> Relocalizer::MatchLines(const FrameFeatures& features, const Map& map,
                                                      const KeyFrame& keyframe,
                                                      const Pose& guess) const {
  const auto pairs = PairLines(features, map, keyframe, model_.matching().lines);
  PoseSolverOptions solver;
  solver.min_support = Support(0, options_.min_line_inliers);
  solver.max_iterations = 15;
  Selection selection;
  SelectLines(pairs, guess, model_, false, &selection);
  return Solve(model_, guess, selection, keyframe.id, solver);
}

std::optional<Relocalization> Relocalizer::MatchPoints(const FrameFeatures& features,
                                                       const Map& map,
                                                       const KeyFrame& keyframe) const {
  std::vector<Pair> pairs;
  std::vector<PosePoint> points;
  for (const FeatureMatch& match : MatchDescriptors(
           features.point_descriptors, keyframe.frame.features->point_descriptors,
           {.max_distance = model_.options().max_hamming.relocalization, .ratio = kDistinctive})) {
    const MapPoint* point = map.Find(keyframe.points[static_cast<std::size_t>(match.train)]);
    if (point == nullptr) continue;
    const PointFeature& feature = features.points[static_cast<std::size_t>(match.query)];
    Pair pair{match.query, point->id, point->p_W, std::nullopt};
    if (feature.depth > 0.0) pair.p_C = model_.camera().Unproject(feature.uv, feature.depth);
    pairs.push_back(pair);
    points.push_back(MakePoseObservation(model_, *point, feature));
  }
  if (static_cast<int>(pairs.size()) < options_.min_matches) return std::nullopt;
  const auto lines = PairLines(features, map, keyframe, model_.matching().lines);
  const auto rough = RansacPose(pairs, points, lines, model_, options_);
  if (!rough) return std::nullopt;
  // A frame to be relocalized is often blurred.
  PoseSolverOptions solver;
  solver.inliers = InlierBounds::ThreeSigma();
  solver.min_support = options_.min_inliers;
  return Refine(model_, *rough, pairs, points, lines, keyframe.id, solver);
}

}  // namespace highwall
