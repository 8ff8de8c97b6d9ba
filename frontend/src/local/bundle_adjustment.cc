#include <highwall/frontend/local/bundle_adjustment.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <map>
#include <unordered_map>
#include <utility>
#include <variant>

#include <ceres/loss_function.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/line3.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/time_offset_factor.h>

#include "local/landmark_kinds.h"
#include "map/anchored_cost.h"

namespace highwall {
namespace {

// [rad] Each adjustment estimates the direction of gravity anew. If it were taken from the
// odometry, whose estimate depends on the tilt of the adjusted map, the two would drift together.
constexpr double kGravitySigma = 0.02;
constexpr double kOfLinesAlone = 1e4;         // the largest trust region for a map without points
constexpr double kMostOfImageMotion = 3.55;   // 95 % of chi-squared with 6 degrees of freedom
constexpr double kMostForgotten = 1.0 / 3.0;  // of the observations, by one adjustment

}  // namespace

// Result of an adjustment.
struct BundleAdjuster::Result {
  struct Motion {
    KeyFrameId keyframe = kNoId;
    Eigen::Vector3d v_WB;
    ImuBias bias;
  };
  template <class Landmark>
  using Estimates =
      std::vector<std::pair<Id<Landmark>, typename LandmarkTraits<Landmark>::VariableType>>;
  template <class Landmark>
  using Places = std::vector<std::pair<Id<Landmark>, typename LandmarkTraits<Landmark>::Geometry>>;

  BundleAdjustmentReport report;
  std::vector<std::pair<KeyFrameId, Pose>> poses;  // T_WC
  std::vector<Motion> motions;
  PerKind<Estimates> landmarks;
  PerKind<Places> carried;  // in W, of landmarks that moved with their keyframe
  SubmapId world = kNoId;   // of the frames and of gravity
  std::vector<std::pair<ReferenceFrameId, Pose>> frames;  // T_FW of the frames that moved
  std::optional<Eigen::Vector3d> gravity_W;               // of a map adjusted as a whole
  OutlierObservations outliers;

  void Write(Map& map) const {
    for (const auto& [id, T_WC] : poses) {
      if (KeyFrame* keyframe = map.keyframe(id)) keyframe->T_WC = T_WC;
    }
    for (const Motion& motion : motions) {
      KeyFrame* keyframe = map.keyframe(motion.keyframe);
      if (keyframe == nullptr) continue;
      keyframe->motion->v_WB = motion.v_WB;
      keyframe->motion->bias = motion.bias;
    }
    ForEachKind([&]<class Landmark>() {
      for (const auto& [id, estimate] : PartOf<Landmark>(landmarks)) {
        Landmark* const landmark = map.Find(id);
        if (landmark != nullptr && !MoveTo(estimate, landmark)) map.Remove(id);
      }
      for (const auto& [id, geometry_W] : PartOf<Landmark>(carried)) {
        if (Landmark* const landmark = map.Find(id)) {
          LandmarkTraits<Landmark>::PositionOf(*landmark) = geometry_W;
        }
      }
    });
    for (const auto& [id, T_FW] : frames) map.factors().Place(id, map.Root(world), T_FW);
    if (gravity_W) map.SetGravity(gravity_W, world);
    Forget(outliers, &map);
  }
};

// The graph of one adjustment and the correspondence of its variables and factors to the map.
class BundleAdjuster::Problem {
 public:
  Problem(const MeasurementModel& model, const BundleAdjustmentOptions& options, int threads)
      : model_(model),
        options_(options),
        threads_(threads),
        T_CB_(model.T_BC().Inverse()),
        losses_(LossesOf(options)) {}

  void AddKeyFrames(const Map& map, std::span<const KeyFrameId> ids, bool fixed) {
    for (const KeyFrameId id : ids) {
      const KeyFrame& keyframe = *map.keyframe(id);
      const Variable<Pose> pose = graph_.AddVariable(keyframe.T_WC * T_CB_);
      if (fixed) graph_.Fix(pose);
      poses_.emplace(id, pose);
      features_.push_back(keyframe.frame.features);
    }
    (fixed ? report_.fixed_keyframes : report_.keyframes) += static_cast<int>(ids.size());
  }

  // Adds the IMU factors between consecutive keyframes. all: as in AddFactors; a few keyframes
  // constrain gravity less than the odometry does.
  void AddMotions(const Map& map, bool all) {
    std::vector<KeyFrameId> ids;
    for (const auto& [id, pose] : poses_) ids.push_back(id);
    if (ids.empty()) return;
    world_ = map.Root(map.keyframe(ids.front())->submap);
    const auto& gravity_W = map.gravity_W(world_);
    if (!gravity_W) return;
    finds_gravity_ = all;
    std::sort(ids.begin(), ids.end());
    const UnitDirection gravity(*gravity_W);
    gravity_ = graph_.AddVariable(gravity);
    graph_.AddFactor(std::make_unique<DirectionPrior>(gravity, kGravitySigma), *gravity_);
    AddTimeOffset(map, ids);
    for (const KeyFrameId id : ids) {
      const std::optional<InertialState>& motion = map.keyframe(id)->motion;
      if (!motion || motion->previous == kNoId || !poses_.contains(motion->previous)) continue;
      AddMotion(map, id, *motion);
    }
  }

  // Adds the user factors on keyframes that move. all: only the keyframes themselves fix the map;
  // then the reference frames of the factors move as well, which a few keyframes hardly constrain.
  void AddFactors(const Map& map, std::span<const KeyFrameId> ids, bool all) {
    if (ids.empty() || map.factors().all().empty()) return;
    world_ = map.Root(map.keyframe(ids.front())->submap);
    for (const MapFactor* factor : FactorsIn(map, world_)) {
      auto cost = std::make_unique<AnchoredCost>(*factor, model_.T_BC());
      std::vector<VariableId> variables;
      bool moves = false;
      for (const KeyFrameId id : cost->keyframes()) {
        const auto pose = poses_.find(id);
        if (pose == poses_.end()) break;
        variables.push_back(pose->second);
        moves = moves || !graph_.IsFixed(pose->second);
      }
      if (variables.size() < cost->keyframes().size() || !moves) continue;
      if (factor->frame != kNoId) variables.push_back(FrameAt(map, factor->frame, !all));
      own_.push_back(graph_.AddFactorToBlocks(std::move(cost), factor->loss, variables));
      if (!graph_.FaultOf(own_.back()).empty()) Exclude({own_.back()});
    }
    report_.user_factors = static_cast<int>(own_.size());
  }

  // Adds what whole images state about the motion to keyframes of `ids`.
  void AddImageMotions(const Map& map, std::span<const KeyFrameId> ids) {
    const auto loss = std::make_shared<ceres::HuberLoss>(kMostOfImageMotion);
    for (const KeyFrameId id : ids) {
      const std::optional<ImageMotion>& motion = map.keyframe(id)->image_motion;
      if (!motion) continue;
      const auto active =
          map.ActiveKeyFrameOf(motion->reference);  // a removed one has a place in it
      const auto reference = poses_.find(active ? active->first : kNoId);
      if (reference == poses_.end() || reference->first == id) continue;
      const Variable<Pose> before = reference->second, after = poses_.at(id);
      if (graph_.IsFixed(before) && graph_.IsFixed(after)) continue;
      MapFactor between;  // of the cameras
      between.poses = {{active->first, active->second}, {id, Pose()}};
      between.cost =
          std::make_shared<RelativePose>(motion->T_reference_C, motion->sqrt_information);
      graph_.AddFactorToBlocks(std::make_unique<AnchoredCost>(between, model_.T_BC()), loss,
                               std::vector<VariableId>{before, after});
    }
  }

  // Adds every landmark observed by a keyframe of `ids`.
  void AddLandmarks(const Map& map, std::span<const KeyFrameId> ids) {
    for (const KeyFrameId id : ids) {
      const KeyFrame& keyframe = *map.keyframe(id);
      ForEachKind([&]<class Landmark>() {
        for (const Id<Landmark> landmark : PartOf<Landmark>(keyframe)) {
          if (landmark == kNoId || PartOf<Landmark>(landmarks_).contains(landmark)) continue;
          AddLandmark(map, keyframe, *map.Find(landmark));
        }
      });
    }
  }

  void Solve(const std::stop_token& stop) {
    if (report_.keyframes == 0) return;
    std::atomic<bool> stopped = false;
    const std::stop_callback on_stop(stop, [&] { stopped = true; });
    SolveSummary summary = Improve(options_.first_iterations, &stopped);
    if (!summary.IsUsable()) return;
    report_.initial_cost = summary.initial_cost;
    // After an early stop, inconsistent observations may be correct and the initial values wrong.
    if (!stopped) {
      RemoveOutliers();
      if (ForgetsTooMuch()) return;
      summary = Improve(options_.second_iterations, &stopped);
    }
    report_.final_cost = summary.final_cost;
    report_.usable = summary.IsUsable();
  }

  Result TakeResult() const {
    Result result;
    result.report = report_;
    result.report.points = static_cast<int>(landmarks_.points.size() + carried_.points.size());
    result.report.lines = static_cast<int>(landmarks_.lines.size() + carried_.lines.size());
    result.report.outliers = static_cast<int>(outliers_.size());
    result.report.observations = static_cast<int>(NumObservations());
    if (!report_.usable) return result;
    for (const auto& [id, pose] : poses_) {
      if (!graph_.IsFixed(pose)) result.poses.emplace_back(id, graph_.Value(pose) * model_.T_BC());
    }
    for (const auto& [id, body] : bodies_) {
      result.motions.push_back({id, graph_.Value(body.velocity), graph_.Value(body.bias)});
    }
    result.world = world_;
    if (finds_gravity_ && report_.imu_factors > 0) {
      result.gravity_W = kStandardGravity * graph_.Value(*gravity_).vector();
    }
    for (const auto& [id, frame] : frames_) {
      if (!graph_.IsFixed(frame)) result.frames.emplace_back(id, graph_.Value(frame));
    }
    ForEachKind([&]<class Landmark>() {
      for (const auto& [id, variable] : PartOf<Landmark>(landmarks_)) {
        PartOf<Landmark>(result.landmarks).emplace_back(id, graph_.Value(variable));
      }
      for (const Carried<Landmark>& carried : PartOf<Landmark>(carried_)) {
        const Variable<Pose> pose = poses_.at(carried.keyframe);
        if (graph_.IsFixed(pose)) continue;
        const Pose T_WC = graph_.Value(pose) * model_.T_BC();
        PartOf<Landmark>(result.carried).emplace_back(carried.landmark, T_WC * carried.geometry_C);
      }
    });
    for (const AnySeen& any : outliers_) {
      const auto add = [&]<class Landmark>(const Seen<Landmark>& seen) {
        PartOf<Landmark>(result.outliers).emplace_back(seen.keyframe, seen.landmark);
      };
      std::visit(add, any);
    }
    return result;
  }

 private:
  // An observation, with its factor.
  template <class Landmark>
  struct Seen {
    FactorId factor;
    KeyFrameId keyframe;
    Id<Landmark> landmark;
    const typename LandmarkTraits<Landmark>::Feature* feature = nullptr;
  };
  using AnySeen = AnyKind<Seen>;
  // A landmark that one keyframe observes.
  template <class Landmark>
  struct Carried {
    Id<Landmark> landmark;
    KeyFrameId keyframe;
    typename LandmarkTraits<Landmark>::Geometry geometry_C;
  };
  template <class Landmark>
  using Carrieds = std::vector<Carried<Landmark>>;
  template <class Landmark>
  using Variables =
      std::unordered_map<Id<Landmark>, Variable<typename LandmarkTraits<Landmark>::VariableType>>;
  template <class Landmark>
  using Loss = std::shared_ptr<ceres::LossFunction>;

  static PerKind<Loss> LossesOf(const BundleAdjustmentOptions& options) {
    PerKind<Loss> losses;
    ForEachKind([&]<class Landmark>() {
      PartOf<Landmark>(losses) =
          std::make_shared<ceres::HuberLoss>(HuberThreshold<Landmark>(options));
    });
    return losses;
  }

  // Solves, without those user factors that turn out not to be evaluable.
  SolveSummary Improve(int iterations, const std::atomic<bool>* stopped) {
    SolveSummary summary = Step(iterations, stopped);
    while (!own_.empty()) {
      std::vector<FactorId> faulty;
      std::ranges::copy_if(own_, std::back_inserter(faulty),
                           [&](FactorId id) { return !graph_.FaultOf(id).empty(); });
      if (faulty.empty() && !summary.IsUsable()) faulty = own_;
      if (faulty.empty()) break;
      Exclude(faulty);
      report_.user_factors = static_cast<int>(own_.size());
      summary = Step(iterations, stopped);
    }
    return summary;
  }

  SolveSummary Step(int iterations, const std::atomic<bool>* stopped) {
    SolveOptions solve;
    solve.max_iterations = iterations;
    solve.function_tolerance = options_.tolerance;
    solve.initial_trust_region_radius = landmarks_.points.empty()
                                            ? std::min(options_.trust_region, kOfLinesAlone)
                                            : options_.trust_region;
    solve.threads = threads_;
    // With the paper's weights many steps fail, and landmarks that are damped less than by Ceres
    // follow their errors (docs/local_mapping.md).
    if (model_.options().weighting != Weighting::kPaper) {
      solve.linear_solver = LinearSolver::kCompactSchur;
    }
    solve.stop = stopped;
    const SolveSummary summary = graph_.Solve(solve);
    report_.rejected_steps += summary.rejected_steps;
    // The evaluation at the start is the first iteration.
    report_.moved = report_.moved || summary.iterations > summary.rejected_steps + 1;
    report_.message = summary.IsUsable() ? "" : summary.message;
    return summary;
  }

  std::size_t NumObservations() const {
    return factors_.size() + outliers_.size() + carried_.points.size() + carried_.lines.size();
  }

  // Removed observations are lost for good: if there are too many, the adjustment itself is wrong.
  bool ForgetsTooMuch() {
    const std::size_t all = NumObservations();
    if (static_cast<double>(outliers_.size()) <= kMostForgotten * static_cast<double>(all)) {
      return false;
    }
    report_.message = "it would forget " + std::to_string(outliers_.size()) + " of " +
                      std::to_string(all) + " observations, more than a third";
    report_.refused = true;
    report_.moved = false;
    return true;
  }

  // Removes user factors that cannot be evaluated.
  void Exclude(const std::vector<FactorId>& faulty) {
    for (const FactorId& factor : faulty) {
      graph_.RemoveFactor(factor);
      std::erase(own_, factor);
    }
    report_.user_factors_excluded += static_cast<int>(faulty.size());
  }

  // Removes the factors of outliers; Write() removes their observations from the map.
  void RemoveOutliers() {
    const auto remove_outlier = [&]<class Landmark>(const Seen<Landmark>& seen) {
      if (IsInlier(seen)) return false;
      graph_.RemoveFactor(seen.factor);
      outliers_.push_back(seen);
      return true;
    };
    std::erase_if(factors_, [&](const AnySeen& any) { return std::visit(remove_outlier, any); });
  }

  // Outside its domain a factor is zero: a landmark behind the camera must not count as an inlier.
  template <class Landmark>
  bool IsInlier(const Seen<Landmark>& seen) const {
    const int dimension = MeasurementModel::Dimension(*seen.feature);
    if (!(graph_.SquaredError(seen.factor) <= options_.inliers.Of(dimension))) return false;
    const Pose T_CW = (graph_.Value(poses_.at(seen.keyframe)) * model_.T_BC()).Inverse();
    return IsInDomain(graph_.Value(PartOf<Landmark>(landmarks_).at(seen.landmark)), *seen.feature,
                      T_CW, model_.projection());
  }

  // Velocity and bias of a keyframe. The bias of the oldest in a chain has a prior.
  struct Body {
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };

  const Body& BodyAt(const Map& map, KeyFrameId id) {
    const auto found = bodies_.find(id);
    if (found != bodies_.end()) return found->second;
    const InertialState& motion = *map.keyframe(id)->motion;
    const Body body{graph_.AddVariable(motion.v_WB), graph_.AddVariable(motion.bias)};
    const bool first = motion.previous == kNoId || !poses_.contains(motion.previous);
    if (first) {
      graph_.AddFactor(std::make_unique<VectorPrior<6>>(
                           motion.bias, motion.bias_sigma.cwiseInverse().asDiagonal()),
                       body.bias);
    }
    return bodies_.emplace(id, body).first->second;
  }

  // Adds the offset between the clocks, of which the newest keyframe knows most. It was still
  // uncertain when the readings of the first ones were taken at their stamps.
  // keyframes: ascending.
  void AddTimeOffset(const Map& map, std::span<const KeyFrameId> keyframes) {
    const auto has_motion = [&](KeyFrameId id) { return map.keyframe(id)->motion.has_value(); };
    const auto newest = std::find_if(keyframes.rbegin(), keyframes.rend(), has_motion);
    if (newest == keyframes.rend()) return;
    const KeyFrame& keyframe = *map.keyframe(*newest);
    const double sigma = keyframe.motion->time_offset_sigma;
    if (!(sigma > 0.0)) return;
    using Offset = Eigen::Matrix<double, 1, 1>;
    const double offset = TimeOffsetOf(keyframe);
    time_offset_ = graph_.AddVariable(offset);
    graph_.AddFactor(std::make_unique<VectorPrior<1>>(Offset(offset), Offset(1.0 / sigma)),
                     *time_offset_);
  }

  static double TimeOffsetOf(const KeyFrame& keyframe) {
    return ToSeconds(keyframe.motion->stamp - keyframe.frame.stamp);
  }

  // Returns how the pose of an image moves to that at the reading of its stamp.
  static MovingPose AtReading(const KeyFrame& keyframe, const ImuSample& reading,
                              std::size_t block) {
    const InertialState& motion = *keyframe.motion;
    return {block, -motion.v_WB, -(reading.gyroscope - motion.bias.head<3>()),
            TimeOffsetOf(keyframe)};
  }

  void AddMotion(const Map& map, KeyFrameId id, const InertialState& motion) {
    const Body& before = BodyAt(map, motion.previous);
    const Body& after = BodyAt(map, id);
    const ImuBias& bias = map.keyframe(motion.previous)->motion->bias;
    const ImuPreintegration& imu = *motion.from_previous;
    std::shared_ptr<ceres::CostFunction> factor = std::make_shared<ImuGravityFactor>(
        imu.NeedsReintegration(bias) ? imu.Reintegrated(bias) : imu, kStandardGravity,
        motion.weight);
    std::vector<VariableId> variables = {poses_.at(motion.previous),
                                         before.velocity,
                                         before.bias,
                                         poses_.at(id),
                                         after.velocity,
                                         after.bias,
                                         *gravity_};
    if (time_offset_) {
      factor = std::make_shared<TimeOffsetFactor>(
          std::move(factor),
          std::vector<MovingPose>{
              AtReading(*map.keyframe(motion.previous), imu.samples().front(),
                        ImuGravityFactor::kPoseI),
              AtReading(*map.keyframe(id), imu.samples().back(), ImuGravityFactor::kPoseJ)});
      variables.push_back(*time_offset_);
    }
    graph_.AddFactorToBlocks(std::move(factor), nullptr, variables);
    ++report_.imu_factors;
  }

  Variable<Pose> FrameAt(const Map& map, ReferenceFrameId id, bool fixed) {
    const auto found = frames_.find(id);
    if (found != frames_.end()) return found->second;
    const Variable<Pose> frame = graph_.AddVariable(*map.factors().T_FW(id, world_));
    if (fixed) {
      graph_.Fix(frame);
    } else if (map.factors().frame(id).upright) {
      graph_.AddFactor(std::make_unique<GravityPrior>(UprightSigma(map, world_)), frame);
    }
    return frames_.emplace(id, frame).first->second;
  }

  // Returns how many keyframes of the adjustment observe a landmark.
  std::ptrdiff_t NumObservers(const auto& landmark) const {
    return std::ranges::count_if(landmark.observations,
                                 [&](const Observation& o) { return poses_.contains(o.keyframe); });
  }

  // Adds a landmark that `keyframe` observes, and its observations. One observation alone is met
  // exactly by a landmark at the right place, however its keyframe moves, and so constrains
  // nothing: a point that is there moves with the keyframe. (A third to a half of all: new ones.)
  // With the paper's weights many steps fail, and the damping of these points shortens them.
  template <class Landmark>
  void AddLandmark(const Map& map, const KeyFrame& keyframe, const Landmark& landmark) {
    using Traits = LandmarkTraits<Landmark>;
    const bool damps = model_.options().weighting == Weighting::kPaper;
    if (kStartsAsObserved<Landmark> && !damps && NumObservers(landmark) == 1) {
      PartOf<Landmark>(carried_).push_back(
          {landmark.id, keyframe.id, keyframe.T_WC.Inverse() * Traits::PositionOf(landmark)});
      return;
    }
    const auto variable = graph_.AddLandmark(Traits::VariableAt(Traits::PositionOf(landmark)));
    PartOf<Landmark>(landmarks_).emplace(landmark.id, variable);
    for (const Observation& o : landmark.observations) {
      const auto pose = poses_.find(o.keyframe);
      if (pose == poses_.end()) continue;
      const FrameFeatures& features = *map.keyframe(o.keyframe)->frame.features;
      const auto& feature = PartOf<Landmark>(features)[static_cast<std::size_t>(o.index)];
      const FactorId factor = graph_.AddFactor(model_.MakeFactor(feature),
                                               PartOf<Landmark>(losses_), pose->second, variable);
      factors_.push_back(Seen<Landmark>{factor, o.keyframe, landmark.id, &feature});
    }
  }

  const MeasurementModel model_;  // a copy: T_BC may be re-estimated while this runs
  const BundleAdjustmentOptions options_;
  const int threads_;
  const Pose T_CB_;
  const PerKind<Loss> losses_;
  FactorGraph graph_;
  std::unordered_map<KeyFrameId, Variable<Pose>> poses_;
  std::unordered_map<KeyFrameId, Body> bodies_;
  std::optional<Variable<UnitDirection>> gravity_;
  std::optional<Variable<double>> time_offset_;  // [s] where it is not known
  bool finds_gravity_ = false;                   // for the map
  SubmapId world_ = kNoId;                       // of gravity and the frames
  std::map<ReferenceFrameId, Variable<Pose>> frames_;
  PerKind<Variables> landmarks_;
  std::vector<std::shared_ptr<const FrameFeatures>> features_;  // keeps the targets of Seen alive
  std::vector<AnySeen> factors_, outliers_;
  PerKind<Carrieds> carried_;
  std::vector<FactorId> own_;  // user factors
  BundleAdjustmentReport report_;
};

BundleAdjuster::BundleAdjuster(const Map& map, const MeasurementModel& model,
                               std::span<const KeyFrameId> free, std::span<const KeyFrameId> fixed,
                               const BundleAdjustmentOptions& options, int threads)
    : problem_(std::make_unique<Problem>(model, (options.Validate(), options), threads)) {
  HIGHWALL_REQUIRE(threads >= 1,
                   "BundleAdjuster: threads must be at least 1, is " + std::to_string(threads));
  std::vector<KeyFrameId> moving(free.begin(), free.end());
  std::vector<KeyFrameId> held(fixed.begin(), fixed.end());
  const bool all = held.empty();
  if (all && !moving.empty()) {
    const auto oldest = std::min_element(moving.begin(), moving.end());
    held.push_back(*oldest);
    moving.erase(oldest);
  }
  problem_->AddKeyFrames(map, held, true);
  problem_->AddKeyFrames(map, moving, false);
  problem_->AddMotions(map, all);
  problem_->AddFactors(map, moving, all);
  problem_->AddImageMotions(map, moving);
  problem_->AddImageMotions(map, held);
  problem_->AddLandmarks(map, free);
}

BundleAdjuster::~BundleAdjuster() = default;

void BundleAdjuster::Solve(const std::stop_token& stop) {
  problem_->Solve(stop);
  result_ = std::make_unique<const Result>(problem_->TakeResult());
  problem_.reset();  // here, so that Write() does not take the time
}

BundleAdjustmentReport BundleAdjuster::Write(Map* map) const {
  result_->Write(*map);
  return result_->report;
}

const OutlierObservations& BundleAdjuster::outliers() const {
  return result_->outliers;
}

BundleAdjustmentReport AdjustBundle(Map& map, const MeasurementModel& model,
                                    std::span<const KeyFrameId> free,
                                    std::span<const KeyFrameId> fixed,
                                    const BundleAdjustmentOptions& options,
                                    const std::stop_token& stop, int threads) {
  BundleAdjuster adjuster(map, model, free, fixed, options, threads);
  adjuster.Solve(stop);
  return adjuster.Write(&map);
}

}  // namespace highwall
