#include <highwall/frontend/relocalizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/frontend/pose_observations.h>

namespace highwall {
namespace {

constexpr int kSampleSize = 3;

// A point of the map and the feature that it may be.
struct Pair {
  int feature = 0;
  PointId point = kNoId;
  Eigen::Vector3d p_W;
  std::optional<Eigen::Vector3d> p_C;  // from the feature's depth
};

// The rigid transform that brings three p_C to their p_W; empty for a thin triangle, or where the
// triangles are not alike.
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

// Points that fit a pose made from three readings: it is rough, so they are counted with three
// times the sigma.
int CountInliers(const Pose& T_WC, const std::vector<PosePoint>& points,
                 const RgbdProjection& projection) {
  constexpr double kBound = 9.0 * 7.815;
  const RgbdProjection::View view = RgbdProjection::At(T_WC.data());
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const PosePoint& point) {
    Eigen::Vector3d r;
    return projection.Evaluate<3>(view, point.rows, point.p_W, &r, nullptr, nullptr) &&
           r.squaredNorm() <= kBound;
  }));
}

// The pose from three pairs that most points fit; empty where fewer than min_inliers do.
// points[i] belongs to pairs[i].
std::optional<Pose> RansacPose(const std::vector<Pair>& pairs, const std::vector<PosePoint>& points,
                               const RgbdProjection& projection,
                               const RelocalizerOptions& options) {
  std::vector<const Pair*> with_depth;
  for (const Pair& pair : pairs) {
    if (pair.p_C) with_depth.push_back(&pair);
  }
  if (static_cast<int>(with_depth.size()) < kSampleSize) return std::nullopt;
  std::mt19937 rng(options.seed);
  std::optional<Pose> best;
  int best_inliers = options.min_inliers - 1;
  for (int iteration = 0; iteration < options.ransac_iterations; ++iteration) {
    std::array<const Pair*, kSampleSize> sample;
    for (const Pair*& s : sample) s = with_depth[rng() % with_depth.size()];
    const auto T_WC = PoseFromTriangle(sample);
    if (!T_WC) continue;
    const int inliers = CountInliers(*T_WC, points, projection);
    if (inliers > best_inliers) {
      best_inliers = inliers;
      best = T_WC;
    }
  }
  return best;
}

}  // namespace

void RelocalizerOptions::Validate() const {
  HIGHWALL_REQUIRE(candidates >= 1, "RelocalizerOptions::candidates must be at least 1");
  HIGHWALL_REQUIRE(query_features >= 10, "RelocalizerOptions::query_features must be at least 10");
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "RelocalizerOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "RelocalizerOptions::ratio must be in (0, 1]");
  HIGHWALL_REQUIRE(min_matches >= 3, "RelocalizerOptions::min_matches must be at least 3");
  HIGHWALL_REQUIRE(min_inliers >= 6, "RelocalizerOptions::min_inliers must be at least 6");
  HIGHWALL_REQUIRE(min_line_inliers >= 4,
                   "RelocalizerOptions::min_line_inliers must be at least 4");
  lines.Validate();
  HIGHWALL_REQUIRE(ransac_iterations >= 1,
                   "RelocalizerOptions::ransac_iterations must be at least 1");
}

Relocalizer::Relocalizer(const MeasurementModel& model, const RelocalizerOptions& options)
    : model_(model), options_(options) {
  options_.Validate();
}

std::optional<Relocalization> Relocalizer::Relocalize(const FrameFeatures& features,
                                                      const Map& map) const {
  for (const KeyFrameId id : RankKeyFrames(features, map)) {
    if (auto found = MatchKeyFrame(features, map, id, map.keyframe(id)->T_WC)) return found;
  }
  return std::nullopt;
}

std::vector<KeyFrameId> Relocalizer::RankKeyFrames(const FrameFeatures& features,
                                                   const Map& map) const {
  // How many of the query's features have a like one in the keyframe.
  const auto count_votes = [&](const cv::Mat& query, const cv::Mat& train) {
    // Features are ordered by level and strength: an even stride takes of every kind.
    const int stride = std::max(1, query.rows / options_.query_features);
    int count = 0;
    for (int i = 0; i < query.rows; i += stride) {
      for (int j = 0; j < train.rows; ++j) {
        if (HammingDistance(query.ptr(i), train.ptr(j)) <= options_.max_hamming) {
          ++count;
          break;
        }
      }
    }
    return count;
  };
  std::vector<std::pair<int, KeyFrameId>> votes;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const FrameFeatures& seen = *map.keyframe(id)->frame.features;
    votes.emplace_back(count_votes(features.point_descriptors, seen.point_descriptors) +
                           count_votes(features.line_descriptors, seen.line_descriptors),
                       id);
  }
  // Of equal votes the newest first: where the camera was last is where it is likely to be.
  std::sort(votes.rbegin(), votes.rend());
  std::vector<KeyFrameId> best;
  for (const auto& [count, id] : votes) {
    if (static_cast<int>(best.size()) == options_.candidates) break;
    best.push_back(id);
  }
  return best;
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
  const FrameFeatures& seen = *keyframe.frame.features;
  if (features.line_descriptors.empty() || seen.line_descriptors.empty()) return std::nullopt;
  const auto as_features = [](const FrameFeatures& frame) {
    LineFeatures lines{{}, frame.line_descriptors};
    for (const LineFeature& line : frame.lines) lines.segments.push_back(line.segment);
    return lines;
  };
  std::vector<PoseLine> lines;
  std::vector<std::pair<int, LineId>> matches;
  for (const FeatureMatch& match :
       MatchLargeMotion(as_features(features), as_features(seen), options_.lines)) {
    const MapLine* line = map.line(keyframe.lines[static_cast<std::size_t>(match.train)]);
    if (line == nullptr) continue;
    const auto& feature = features.lines[static_cast<std::size_t>(match.query)];
    if (const auto pose_line = MakePoseLine(model_, *line, feature, guess)) {
      lines.push_back(*pose_line);
      matches.emplace_back(match.query, line->id);
    }
  }
  PoseSolverOptions solver;
  solver.min_support = 2 * options_.min_line_inliers;
  solver.max_iterations = 15;
  const auto solution = SolvePose(guess, model_.projection(), {}, lines, solver);
  if (!solution) return std::nullopt;
  Relocalization result{solution->T_WC, keyframe.id, {}, {}};
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (solution->line_inliers[i]) result.lines.push_back(matches[i]);
  }
  return result;
}

std::optional<Relocalization> Relocalizer::MatchPoints(const FrameFeatures& features,
                                                       const Map& map,
                                                       const KeyFrame& keyframe) const {
  std::vector<Pair> pairs;
  std::vector<PosePoint> points;
  for (const FeatureMatch& match :
       MatchDescriptors(features.point_descriptors, keyframe.frame.features->point_descriptors,
                        {.max_distance = options_.max_hamming, .ratio = options_.ratio})) {
    const MapPoint* point = map.point(keyframe.points[static_cast<std::size_t>(match.train)]);
    if (point == nullptr) continue;
    const PointFeature& feature = features.points[static_cast<std::size_t>(match.query)];
    Pair pair{match.query, point->id, point->p_W, std::nullopt};
    if (feature.depth > 0.0) pair.p_C = model_.camera().Unproject(feature.uv, feature.depth);
    pairs.push_back(pair);
    points.push_back(MakePosePoint(model_, *point, feature));
  }
  if (static_cast<int>(pairs.size()) < options_.min_matches) return std::nullopt;
  const auto rough = RansacPose(pairs, points, model_.projection(), options_);
  if (!rough) return std::nullopt;
  PoseSolverOptions solver;
  solver.min_support = options_.min_inliers;
  const auto solution = SolvePose(*rough, model_.projection(), points, {}, solver);
  if (!solution) return std::nullopt;
  Relocalization result{solution->T_WC, keyframe.id, {}, {}};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (solution->point_inliers[i]) result.points.emplace_back(pairs[i].feature, pairs[i].point);
  }
  return result;
}

}  // namespace highwall
