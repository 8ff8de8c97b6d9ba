#include "loops/keyframe_graph.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <ceres/cost_function.h>
#include <Eigen/Cholesky>

#include <highwall/core/error.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/internal/cost_fault.h>

#include "map/anchored_cost.h"
#include "map/pose_covariance.h"
#include "map/relative_information.h"

namespace highwall {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Standard deviations per step between two keyframes of errors that images share: of the
// calibration, of depth, of row times.
constexpr double kStepTranslation = 0.005;  // [m]
constexpr double kStepRotation = 0.003;     // [rad]

Matrix6 Covariance(double sigma_translation, double sigma_rotation) {
  Vector6 variances;
  variances << Eigen::Vector3d::Constant(sigma_translation * sigma_translation),
      Eigen::Vector3d::Constant(sigma_rotation * sigma_rotation);
  return variances.asDiagonal();
}

// Nodes i and i + 1 are successive keyframes: what connects them is a step of the motion, also
// where they are of different submaps, or where a loop has merged these.
PoseGraphEdgeKind KindBetween(std::int64_t i, std::int64_t j) {
  return std::abs(j - i) == 1 ? PoseGraphEdgeKind::kOdometry : PoseGraphEdgeKind::kLoop;
}

// The inverse, symmetric to the last bit.
PoseCovariance InformationOf(const PoseCovariance& covariance) {
  const PoseCovariance inverse = covariance.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

// Holds roll and pitch of every node by an edge from a fixed node: its measurement has the sigma
// kSigma about the horizontal axes of W, expressed in C, and no information otherwise.
void HoldGravity(PoseGraph* graph) {
  constexpr double kSigma = 1e-3;  // [rad]
  constexpr double kNoInformation =
      1e-6;  // [1/m^2], [1/rad^2]: practically none, but positive definite
  const std::size_t keyframes = graph->nodes.size();
  const auto world = static_cast<std::int64_t>(keyframes);
  graph->nodes.push_back({world, Pose(), true});
  for (std::size_t i = 0; i < keyframes; ++i) {
    const Pose& T_WC = graph->nodes[i].pose;
    const Eigen::Vector3d up_C = T_WC.R().transpose() * Eigen::Vector3d::UnitZ();
    Matrix6 information = kNoInformation * Matrix6::Identity();
    information.bottomRightCorner<3, 3>() +=
        (Eigen::Matrix3d::Identity() - up_C * up_C.transpose()) / (kSigma * kSigma);
    graph->edges.push_back({world, graph->nodes[i].id, PoseGraphEdgeKind::kLoop, T_WC, information,
                            /*trusted=*/true});
  }
}

// Returns an id after the keyframes and the node of gravity.
std::int64_t NodeOfFrame(const KeyFrameGraph& graph, std::size_t frame) {
  return static_cast<std::int64_t>(graph.keyframes.size() + 1 + frame);
}

// Numbers the series of user factors (KeyFrameGraph::series).
class SeriesNumbers {
 public:
  // Of the measurements with one source, frame, number of bodies and number of residuals.
  std::size_t Of(const MapFactor& factor) {
    return Number({factor.source, factor.frame, factor.poses.size(), factor.cost->num_residuals()});
  }
  // Of the tilt of a frame, which no body measures.
  std::size_t OfTilt(ReferenceFrameId frame) { return Number({std::string(), frame, 0, 0}); }

 private:
  using Kind = std::tuple<std::string, ReferenceFrameId, std::size_t, int>;

  std::size_t Number(const Kind& kind) {
    return numbers_.try_emplace(kind, numbers_.size()).first->second;
  }

  std::map<Kind, std::size_t> numbers_;
};

// Adds the user factors, and their reference frames as nodes.
void AddFactors(const Map& map, SubmapId submap, KeyFrameGraph* result) {
  PoseGraph& graph = result->graph;
  SeriesNumbers series;
  for (const MapFactor* factor : FactorsIn(map, submap)) {
    auto cost = std::make_shared<AnchoredCost>(*factor, Pose());
    PoseGraphFactor added{{}, cost, factor->loss};
    for (const KeyFrameId id : cost->keyframes()) added.nodes.push_back(result->NodeOf(id));
    if (const ReferenceFrameId id = factor->frame; id != kNoId) {
      const std::int64_t node = NodeOfFrame(*result, id.index());
      if (result->frames.try_emplace(id, graph.nodes.size()).second) {
        graph.nodes.push_back({node, *map.factors().T_FW(id, map.Root(submap))});
        if (map.factors().frame(id).upright) {
          graph.factors.push_back(
              {{node}, std::make_shared<GravityPrior>(UprightSigma(map, submap))});
          result->series.push_back(series.OfTilt(id));
        }
      }
      added.nodes.push_back(node);
    }
    std::vector<const double*> blocks;
    for (const KeyFrameId id : cost->keyframes()) {
      blocks.push_back(graph.nodes[static_cast<std::size_t>(result->NodeOf(id))].pose.data());
    }
    if (factor->frame != kNoId) {
      blocks.push_back(graph.nodes[result->frames.at(factor->frame)].pose.data());
    }
    if (std::string fault = internal::FaultOf(*cost, blocks); !fault.empty()) {
      if (result->excluded++ == 0) result->fault = std::move(fault);
      continue;
    }
    graph.factors.push_back(std::move(added));
    result->series.push_back(series.Of(*factor));
  }
}

// Transfers a loop to the keyframes that its own are anchored to; empty if they are not in the
// graph, or are neighbours by now, which odometry connects.
std::optional<LoopEdge> Carried(const Map& map, const LoopEdge& loop,
                                const std::vector<KeyFrameId>& keyframes) {
  const auto match = map.ActiveKeyFrameOf(loop.match),
             keyframe = map.ActiveKeyFrameOf(loop.keyframe);
  if (!match || !keyframe) return std::nullopt;
  const auto i = std::ranges::lower_bound(keyframes, match->first);
  const auto j = std::ranges::lower_bound(keyframes, keyframe->first);
  if (i == keyframes.end() || *i != match->first) return std::nullopt;
  if (j == keyframes.end() || *j != keyframe->first) return std::nullopt;
  if (match->first == loop.match && keyframe->first == loop.keyframe) return loop;
  if (std::abs(i - j) <= 1) return std::nullopt;
  return LoopEdge{match->first, keyframe->first,
                  match->second * loop.Z * keyframe->second.Inverse(),
                  CarriedTo(keyframe->second, loop.covariance)};
}

// Returns the older keyframe with which a submap shares most landmarks, and the keyframe of the
// submap; the nearest two if they share none. first: the submap's first keyframe.
std::pair<std::size_t, std::size_t> Seam(const Map& map, std::size_t first,
                                         const KeyFrameGraph& graph) {
  const SubmapId submap = map.keyframe(graph.keyframes[first])->submap;
  std::pair<std::size_t, std::size_t> seam{first - 1, first};
  int most = 0;
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t j = first; j < graph.keyframes.size(); ++j) {
    const KeyFrame& keyframe = *map.keyframe(graph.keyframes[j]);
    if (keyframe.submap != submap) continue;
    for (const auto& [id, shared] : map.Covisible(keyframe.id, std::max(most, 1))) {
      if (id >= graph.keyframes[first]) continue;
      if (shared > most) seam = {static_cast<std::size_t>(graph.NodeOf(id)), j};
      most = std::max(most, shared);
    }
    for (std::size_t i = 0; i < first && most == 0; ++i) {
      const double distance = (graph.graph.nodes[i].pose.p() - keyframe.T_WC.p()).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      seam = {i, j};
    }
  }
  return seam;
}

// Returns whether a keyframe C, when it was made, was placed in the map around an older one. It was
// not across a seam of submaps, nor where tracking was lost and found elsewhere: then C shares
// landmarks with older keyframes, but none of them with R.
bool BeganInOnePlace(const Map& map, const KeyFrame& R, const KeyFrame& C) {
  if (R.submap != C.submap) return false;
  std::vector<KeyFrameId> older;
  for (const auto& [id, shared] : map.Covisible(C.id, 1)) {
    if (id == R.id) return true;
    if (id < C.id) older.push_back(id);
  }
  const auto touches_R = [&](KeyFrameId id) {
    return std::ranges::any_of(map.Covisible(id, 1),
                               [&](const auto& other) { return other.first == R.id; });
  };
  return older.empty() || std::ranges::any_of(older, touches_R);
}

// The edges that hold the map as it is.
class PresentEdges {
 public:
  PresentEdges(const Map& map, const MeasurementModel& model, const KeyFrameGraphOptions& options,
               KeyFrameGraph* result)
      : map_(map), model_(model), options_(options), result_(*result) {}

  // Adds edges between node i and older ones. before: the preceding one in its submap; empty: it
  // is the first one.
  void Add(std::size_t i, std::optional<std::size_t> before) {
    PoseGraph& graph = result_.graph;
    const std::size_t first = graph.edges.size();
    if (before) {
      graph.edges.push_back(Edge(*before, i));
    } else {
      const auto [older, newer] = Seam(map_, i, result_);
      graph.edges.push_back(Edge(older, newer));
    }
    for (const auto& [id, shared] : map_.Covisible(result_.keyframes[i], options_.min_shared)) {
      if (graph.edges.size() - first > static_cast<std::size_t>(options_.neighbours)) break;
      if (id >= result_.keyframes[i] || (before && id == result_.keyframes[*before])) continue;
      graph.edges.push_back(Edge(static_cast<std::size_t>(result_.NodeOf(id)), i));
    }
    // They depend on the same landmarks: together they have the information of one.
    const auto count = static_cast<double>(graph.edges.size() - first);
    for (std::size_t e = first; e < graph.edges.size(); ++e) graph.edges[e].information /= count;
  }

 private:
  // Returns an edge with the current transform between two nodes. Shared errors are those after the
  // steps between them, fully correlated, so that parallel edges have no more information on a long
  // path than odometry.
  PoseGraphEdge Edge(std::size_t i, std::size_t j) const {
    const PoseGraph& graph = result_.graph;
    const Pose Z = graph.nodes[i].pose.Inverse() * graph.nodes[j].pose;
    const auto steps = static_cast<double>(j - i);
    const std::int64_t from = graph.nodes[i].id, to = graph.nodes[j].id;
    const Matrix6 covariance =
        RelativeCovariance(map_, model_, result_.keyframes[i], result_.keyframes[j]) +
        Covariance(steps * kStepTranslation + options_.drift_translation * Z.p().norm(),
                   steps * kStepRotation + options_.drift_rotation * Z.Angle());
    return {from, to, KindBetween(from, to), Z, InformationOf(covariance), /*trusted=*/true};
  }

  const Map& map_;
  const MeasurementModel& model_;
  const KeyFrameGraphOptions& options_;
  KeyFrameGraph& result_;
};

}  // namespace

PoseCovariance CovarianceOf(const LoopEdge& loop, const KeyFrameGraphOptions& options) {
  return loop.covariance + Covariance(options.loop_translation, options.loop_rotation);
}

PoseCovariance RelativeCovariance(const Map& map, const MeasurementModel& model,
                                  KeyFrameId reference, KeyFrameId keyframe) {
  PoseCovariance information = RelativeInformation(map, model, reference, keyframe);
  const KeyFrame& R = *map.keyframe(reference);
  const KeyFrame& C = *map.keyframe(keyframe);
  if (const auto& motion = C.image_motion) {
    const auto active = map.ActiveKeyFrameOf(motion->reference);
    if (active && active->first == reference) {
      information += motion->sqrt_information.transpose() * motion->sqrt_information;
    }
  }
  information = InflatedInformation(information);
  if (!R.covariance || !C.covariance || !BeganInOnePlace(map, R, C)) return information.inverse();
  PoseCovariance independent = C.covariance->cast<double>() +
                               CarriedTo(C.T_WC.Inverse() * R.T_WC, R.covariance->cast<double>());
  constexpr double kSinglePrecision = 1e-7;
  independent.diagonal().array() += kSinglePrecision * independent.trace();
  return LowerCovariance(independent, information);
}

std::int64_t KeyFrameGraph::NodeOf(KeyFrameId keyframe) const {
  const auto found = std::lower_bound(keyframes.begin(), keyframes.end(), keyframe);
  HIGHWALL_REQUIRE(found != keyframes.end() && *found == keyframe,
                   "KeyFrameGraph::NodeOf: the keyframe is not in the graph");
  return found - keyframes.begin();
}

void KeyFrameGraph::AllowBias(const LoopEdge& loop, const KeyFrameGraphOptions& options) {
  const auto steps = static_cast<double>(std::abs(NodeOf(loop.keyframe) - NodeOf(loop.match)));
  const double factor = 1.0 + steps * options.drift_bias * options.drift_bias;
  const auto last = static_cast<std::int64_t>(keyframes.size()) - 1;
  for (PoseGraphEdge& edge : graph.edges) {
    // Gravity does not drift.
    if (edge.trusted && edge.i <= last) edge.information /= factor;
  }
}

void KeyFrameGraph::Add(const LoopEdge& loop, const KeyFrameGraphOptions& options) {
  const std::int64_t match = NodeOf(loop.match), keyframe = NodeOf(loop.keyframe);
  loop_edges.push_back(graph.edges.size());
  graph.edges.push_back({match, keyframe, KindBetween(match, keyframe), loop.Z,
                         InformationOf(CovarianceOf(loop, options))});
}

std::map<ReferenceFrameId, Pose> KeyFrameGraph::FramePoses() const {
  std::map<ReferenceFrameId, Pose> poses;
  for (const auto& [id, node] : frames) poses.emplace(id, graph.nodes[node].pose);
  return poses;
}

KeyFrameGraph MakeKeyFrameGraph(const Map& map, const MeasurementModel& model,
                                std::span<const LoopEdge> loops,
                                const KeyFrameGraphOptions& options, SubmapId submap) {
  options.Validate();
  KeyFrameGraph result;
  result.keyframes = map.KeyFramesOf(submap);
  HIGHWALL_REQUIRE(result.keyframes.size() >= 2,
                   "MakeKeyFrameGraph: the submap must have at least two keyframes, has " +
                       std::to_string(result.keyframes.size()));
  PoseGraph& graph = result.graph;
  for (std::size_t i = 0; i < result.keyframes.size(); ++i) {
    graph.nodes.push_back(
        {static_cast<std::int64_t>(i), map.keyframe(result.keyframes[i])->T_WC, i == 0});
  }
  PresentEdges present(map, model, options, &result);
  std::map<SubmapId, std::size_t> newest;  // latest node of each submap
  for (std::size_t i = 0; i < result.keyframes.size(); ++i) {
    const KeyFrame& keyframe = *map.keyframe(result.keyframes[i]);
    const auto [before, begins] = newest.try_emplace(keyframe.submap, i);
    if (i > 0) present.Add(i, begins ? std::nullopt : std::optional(before->second));
    before->second = i;
  }
  for (const LoopEdge& loop : loops) {
    if (const auto carried = Carried(map, loop, result.keyframes)) result.Add(*carried, options);
  }
  if (options.hold_gravity && map.gravity_W(submap)) HoldGravity(&graph);
  if (!map.factors().all().empty()) AddFactors(map, submap, &result);
  return result;
}

std::optional<double> LoopChi2(KeyFrameGraph graph, const LoopEdge& loop,
                               const KeyFrameGraphOptions& options) {
  graph.AllowBias(loop, options);
  std::vector<PoseGraphNode>& nodes = graph.graph.nodes;
  const std::int64_t match = graph.NodeOf(loop.match), keyframe = graph.NodeOf(loop.keyframe);
  nodes.front().fixed = false;
  nodes[static_cast<std::size_t>(match)].fixed = true;
  const Pose& T = nodes[static_cast<std::size_t>(keyframe)].pose;
  const Pose measured = nodes[static_cast<std::size_t>(match)].pose * loop.Z;
  Vector6 error;
  error << measured.p() - T.p(), so3::Log(T.q().conjugate() * measured.q());
  const std::int64_t ids[] = {keyframe};
  const std::optional<Eigen::MatrixXd> drift = PoseGraphCovariance(graph.graph, ids);
  if (!drift) return std::nullopt;
  const Matrix6 covariance =
      *drift + RotatedInformation(CovarianceOf(loop, options), measured.R());  // p is in W
  return error.dot(covariance.llt().solve(error));
}

}  // namespace highwall
