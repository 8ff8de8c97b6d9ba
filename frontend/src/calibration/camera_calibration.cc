#include <highwall/frontend/calibration/camera_calibration.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <ceres/loss_function.h>
#include <Eigen/Cholesky>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/factors/intrinsic_reprojection.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

// [rad] Minimum angle between the first view of a point without depth and another: with a pixel of
// noise the relative sigma of its distance is then a tenth.
constexpr double kLeastParallax = 0.02;

// Keyframes up to which the unknowns that remain without the points are solved for densely.
constexpr std::size_t kMostProjected = 60;

using PatternMatrix = Eigen::Matrix<double, DepthPattern::kNodes, DepthPattern::kNodes>;

// Returns the share of each node in the mean over the image: half of that of the others at an edge,
// a quarter in a corner.
DepthPattern::Vector MeanShares() {
  constexpr int kColumns = DepthPattern::kColumns, kRows = DepthPattern::kRows;
  DepthPattern::Vector shares;
  for (int node = 0; node < DepthPattern::kNodes; ++node) {
    const int column = node % kColumns, row = node / kColumns;
    shares[node] = (column == 0 || column == kColumns - 1 ? 0.5 : 1.0) *
                   (row == 0 || row == kRows - 1 ? 0.5 : 1.0);
  }
  return shares / shares.sum();
}

// Returns the square-root information of nodes that differ by `step` [1/m] from one to the next,
// along rows and columns. Their common part belongs to the offset: their mean over the image is 0,
// whatever part was observed, so that a camera has the same pattern in each recording.
PatternMatrix SmoothPattern(double step) {
  constexpr int kColumns = DepthPattern::kColumns, kNodes = DepthPattern::kNodes;
  constexpr double kMean = 1e-6;  // [1/m] nearly zero, but numerically well-conditioned
  const DepthPattern::Vector mean = MeanShares();
  PatternMatrix information = mean * mean.transpose() / (kMean * kMean);
  const auto tie = [&](int a, int b) {
    const double weight = 1.0 / (step * step);
    information(a, a) += weight;
    information(b, b) += weight;
    information(a, b) -= weight;
    information(b, a) -= weight;
  };
  for (int node = 0; node < kNodes; ++node) {
    if (node % kColumns + 1 < kColumns) tie(node, node + 1);
    if (node + kColumns < kNodes) tie(node, node + kColumns);
  }
  return information.llt().matrixU();
}

// Problem of the keyframes and points of a map, and the camera.
class CameraGraph {
 public:
  CameraGraph(const Map& map, const MeasurementModel& model,
              const CameraCalibrationOptions& options)
      : map_(map),
        model_(model),
        loss_(std::make_shared<ceres::HuberLoss>(options.huber)),
        intrinsics_(graph_.AddVariable(Known(model.camera()))),
        inverse_depth_(graph_.AddVariable(0.0)),
        pattern_of_(options.pattern_of),
        pattern_(graph_.AddVariable(DepthPattern::Vector(DepthPattern::Vector::Zero()))) {
    if (pattern_of_) {
      graph_.AddFactor(std::make_unique<VectorPrior<DepthPattern::kNodes>>(
                           DepthPattern::Vector(DepthPattern::Vector::Zero()),
                           SmoothPattern(options.pattern_step)),
                       pattern_);
    } else {
      graph_.Fix(pattern_);
    }
    graph_.AddFactor(std::make_unique<VectorPrior<1>>(
                         VectorPrior<1>::Vector::Zero(),
                         VectorPrior<1>::Matrix::Constant(1.0 / options.inverse_depth)),
                     inverse_depth_);
    if (!options.intrinsics) {
      graph_.Fix(intrinsics_);
      return;
    }
    const PinholeCamera& camera = model.camera();
    const Eigen::Vector4d sigma(options.focal_share * camera.fx, options.focal_share * camera.fy,
                                options.centre_share * camera.width,
                                options.centre_share * camera.height);
    graph_.AddFactor(std::make_unique<VectorPrior<4>>(
                         Known(camera), Eigen::Matrix4d(sigma.cwiseInverse().asDiagonal())),
                     intrinsics_);
  }

  void AddKeyFrames(std::span<const KeyFrameId> ids) {
    for (const KeyFrameId id : ids) {
      const Variable<Pose> pose = graph_.AddVariable(map_.keyframe(id)->T_WC);
      if (poses_.empty()) graph_.Fix(pose);
      poses_.emplace(id, pose);
    }
  }

  // Adds the points that two or more keyframes observe and whose distance is observable.
  void AddPoints() {
    for (const PointId id : map_.ids<MapPoint>()) {
      const MapPoint& point = *map_.Find(id);
      std::vector<Observation> seen;
      std::copy_if(point.observations.begin(), point.observations.end(), std::back_inserter(seen),
                   [&](const Observation& o) { return poses_.contains(o.keyframe); });
      if (seen.size() < 2 || !TellDistance(point.p_W, seen)) continue;
      const Variable<Point> variable = graph_.AddLandmark(Point(point.p_W));
      ++points_;
      for (const Observation& o : seen) Observe(o, variable);
    }
  }

  // Returns empty, and the reason, if the map does not determine the camera.
  std::optional<CameraCalibration> Solve(const CameraCalibrationOptions& options,
                                         std::string* reason) {
    const auto fail = [reason](const std::string& why) {
      *reason = why;
      return std::nullopt;
    };
    if (poses_.size() < 3) return fail("less than three keyframes");
    if (points_ == 0) return fail("no point that two keyframes see");
    const std::array<VariableId, 3> shared = {intrinsics_, inverse_depth_, pattern_};
    const SolveSummary summary = graph_.Solve(
        {.max_iterations = options.max_iterations,
         .linear_solver = poses_.size() <= kMostProjected ? LinearSolver::kVariableProjection
                                                          : LinearSolver::kAuto});
    if (!summary.IsUsable()) return fail("calibration failed: " + summary.message);
    const auto covariance = graph_.Covariance(shared);
    if (!covariance) return fail("calibration failed: " + graph_.Undetermined());
    CameraCalibration result;
    result.keyframes = static_cast<int>(poses_.size());
    result.points = points_;
    result.observations = observations_;
    const int unknowns = 6 * (result.keyframes - 1) + 3 * points_ + (options.intrinsics ? 5 : 1) +
                         (pattern_of_ ? DepthPattern::kNodes - 1 : 0);
    result.error = 2.0 * summary.final_cost / std::max(1, rows_ - unknowns);
    const double growth = std::sqrt(std::max(1.0, result.error));
    const Eigen::VectorXd sigmas = growth * covariance->diagonal().cwiseSqrt();
    result.intrinsics = graph_.Value(intrinsics_);
    result.sigma = sigmas.head<4>();
    result.inverse_depth_offset = graph_.Value(inverse_depth_);
    result.inverse_depth_sigma = sigmas[4];
    const double depth = MedianDepth();
    result.inverse_depth_seen = result.inverse_depth_sigma * depth <= options.good_depth;
    if (!pattern_of_) return result;
    result.depth_pattern.nodes = graph_.Value(pattern_);
    result.depth_pattern_sigma.nodes = sigmas.tail<DepthPattern::kNodes>();
    result.depth_pattern_seen = result.depth_pattern_sigma.Rms() * depth <= options.good_depth;
    return result;
  }

 private:
  static Eigen::Vector4d Known(const PinholeCamera& camera) {
    return {camera.fx, camera.fy, camera.cx, camera.cy};
  }

  const PointFeature& FeatureOf(const Observation& o) const {
    return map_.keyframe(o.keyframe)->frame.features->points[static_cast<std::size_t>(o.index)];
  }

  // By depth or by parallax: without either the normal equations are singular.
  bool TellDistance(const Eigen::Vector3d& p_W, const std::vector<Observation>& seen) const {
    const double most = std::cos(kLeastParallax);
    std::vector<Eigen::Vector3d> rays;
    for (const Observation& o : seen) {
      if (FeatureOf(o).depth > 0.0) return true;
      rays.push_back((p_W - map_.keyframe(o.keyframe)->T_WC.p()).normalized());
      if (rays.front().dot(rays.back()) < most) return true;
    }
    return false;
  }

  void Observe(const Observation& o, const Variable<Point>& point) {
    const PointFeature& feature = FeatureOf(o);
    graph_.AddFactor(std::make_unique<IntrinsicReprojection>(
                         model_.Rows(feature), model_.projection(), SharesOf(feature)),
                     loss_, poses_.at(o.keyframe), point, intrinsics_, inverse_depth_, pattern_);
    if (feature.depth > 0.0) depths_.push_back(feature.depth);
    rows_ += MeasurementModel::Dimension(feature);
    ++observations_;
  }

  // Returns the shares of the pattern's nodes in the depth of a feature, whose position is
  // undistorted.
  DepthPattern::Vector SharesOf(const PointFeature& feature) const {
    if (!pattern_of_ || feature.depth <= 0.0) return DepthPattern::Vector::Zero();
    const PinholeCamera& camera = *pattern_of_;
    const Eigen::Vector2d raw =
        camera.Project(camera.WithoutDistortion().Unproject(feature.uv, 1.0));
    return DepthPattern::Shares(raw.x(), raw.y(), camera.width, camera.height);
  }

  // [m] Infinite without depth, so that nothing is reported as observed.
  double MedianDepth() {
    if (depths_.empty()) return std::numeric_limits<double>::infinity();
    const auto median = depths_.begin() + static_cast<std::ptrdiff_t>(depths_.size() / 2);
    std::nth_element(depths_.begin(), median, depths_.end());
    return *median;
  }

  const Map& map_;
  const MeasurementModel& model_;
  const std::shared_ptr<ceres::LossFunction> loss_;
  FactorGraph graph_;
  const Variable<Eigen::Vector4d> intrinsics_;
  const Variable<double> inverse_depth_;
  const std::optional<PinholeCamera> pattern_of_;
  const Variable<DepthPattern::Vector> pattern_;
  std::unordered_map<KeyFrameId, Variable<Pose>> poses_;
  std::vector<double> depths_;  // [m] readings
  int points_ = 0, observations_ = 0, rows_ = 0;
};

std::vector<std::string> Advice(const CameraCalibration& found, bool intrinsics, bool pattern) {
  constexpr const char* kMotion[] = {
      "fx is hardly observable: turn the camera left and right, by at least half of its field of "
      "view",
      "fy is hardly observable: tilt the camera up and down, by at least half of its field of view",
      "cx is hardly observable: roll the camera about its optical axis, back and forth by a "
      "quarter",
      "cy is hardly observable: roll the camera about its optical axis, back and forth by a "
      "quarter"};
  std::vector<std::string> advice;
  for (int i = 0; intrinsics && i < 4; ++i) {
    if (!found.seen[static_cast<std::size_t>(i)]) advice.emplace_back(kMotion[i]);
  }
  if (!found.inverse_depth_seen) {
    advice.emplace_back(
        "the offset of depth is hardly observable: look at the same things from near and from far, "
        "half a metre back and forth and more");
  }
  if (pattern && !found.depth_pattern_seen) {
    advice.emplace_back(
        "the pattern of depth over the image is hardly observable: let the same things pass "
        "through all of the image, its corners too");
  }
  return advice;
}

}  // namespace

void CameraCalibrationOptions::Validate() const {
  RequirePositiveFinite(focal_share, "CameraCalibrationOptions::focal_share");
  RequirePositiveFinite(centre_share, "CameraCalibrationOptions::centre_share");
  RequirePositiveFinite(inverse_depth, "CameraCalibrationOptions::inverse_depth");
  RequirePositiveFinite(pattern_step, "CameraCalibrationOptions::pattern_step");
  RequirePositiveFinite(good_depth, "CameraCalibrationOptions::good_depth");
  RequirePositiveFinite(huber, "CameraCalibrationOptions::huber");
  RequirePositiveFinite(good_share, "CameraCalibrationOptions::good_share");
  RequireAtLeast(max_iterations, 1, "CameraCalibrationOptions::max_iterations");
}

std::optional<CameraCalibration> CalibrateCamera(const Map& map, const MeasurementModel& model,
                                                 SubmapId submap,
                                                 const CameraCalibrationOptions& options,
                                                 std::string* reason) {
  return CalibrateCamera(map, model, map.KeyFramesOf(submap), options, reason);
}

std::optional<CameraCalibration> CalibrateCamera(const Map& map, const MeasurementModel& model,
                                                 std::span<const KeyFrameId> keyframes,
                                                 const CameraCalibrationOptions& options,
                                                 std::string* reason) {
  options.Validate();
  CameraGraph graph(map, model, options);
  graph.AddKeyFrames(keyframes);
  graph.AddPoints();
  std::string why;
  std::optional<CameraCalibration> solved = graph.Solve(options, &why);
  if (reason != nullptr) *reason = why;
  if (!solved) return std::nullopt;
  CameraCalibration& found = *solved;
  for (int i = 0; i < 4; ++i) {
    found.seen[static_cast<std::size_t>(i)] =
        options.intrinsics && found.sigma[i] <= options.good_share * found.intrinsics[i % 2];
  }
  found.advice = Advice(found, options.intrinsics, options.pattern_of.has_value());
  return solved;
}

}  // namespace highwall
