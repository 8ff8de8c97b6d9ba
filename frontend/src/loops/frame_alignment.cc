#include "loops/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

#include "map/anchored_cost.h"

namespace highwall {
namespace {

constexpr std::size_t kMaxFactors =
    200;                      // maximum number of factors, evenly spread: enough for a path
constexpr int kHeadings = 8;  // initial values of the search

std::vector<const MapFactor*> FactorsOf(const Map& map, ReferenceFrameId frame, SubmapId submap) {
  std::vector<const MapFactor*> all, some;
  for (const MapFactor& factor : map.factors().all()) {
    const bool inside = std::ranges::all_of(factor.poses, [&](const AnchoredBodyPose& pose) {
      return map.Root(map.keyframe(pose.keyframe)->submap) == map.Root(submap);
    });
    if (factor.frame == frame && inside) all.push_back(&factor);
  }
  const std::size_t count = std::min(all.size(), kMaxFactors);
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

// Problem with the frame as the only unknown.
class Alignment {
 public:
  Alignment(const Map& map, ReferenceFrameId frame, SubmapId submap)
      : upright_(map.factors().frame(frame).upright), T_FW_(graph_.AddVariable(Pose())) {
    for (const MapFactor* factor : FactorsOf(map, frame, submap)) {
      auto cost = std::make_shared<AnchoredCost>(*factor, Pose());
      std::vector<VariableId> variables;
      for (const KeyFrameId id : cost->keyframes()) variables.push_back(PoseOf(map, id));
      variables.push_back(T_FW_);
      factors_.push_back({cost, factor->loss, std::move(variables), {}});
    }
    if (upright_) {
      graph_.AddFactor(std::make_unique<GravityPrior>(UprightSigma(map, submap)), T_FW_);
    }
  }

  bool IsEmpty() const { return factors_.empty(); }

  // Solves from all headings and keeps the best. First without losses, whose gradient vanishes far
  // away.
  bool Solve() {
    ExcludeFaulty();
    if (IsEmpty()) return false;
    std::optional<Pose> best;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kHeadings; ++i) {
      graph_.SetValue(T_FW_, Heading(i));
      const SolveSummary summary = graph_.Solve();
      if (!summary.IsUsable() || !(summary.final_cost < least)) continue;
      least = summary.final_cost;
      best = graph_.Value(T_FW_);
    }
    if (!best) return false;
    graph_.SetValue(T_FW_, *best);
    Add(/*robust=*/true);
    return graph_.Solve().IsUsable();
  }

  Pose value() const { return graph_.Value(T_FW_); }

  // Returns the largest sigma of its rotation [rad], that of its heading if it is upright: on a
  // straight path the tilt is known by the prior alone, and need not be better. Infinite if it is
  // not determined.
  double AngleSigma() const {
    const auto covariance = graph_.Covariance(T_FW_);
    if (!covariance) return std::numeric_limits<double>::infinity();
    return std::sqrt(upright_ ? (*covariance)(5, 5) : covariance->diagonal().tail<3>().maxCoeff());
  }

 private:
  static Pose Heading(int i) {
    return Pose::FromTangent({0, 0, 0}, {0, 0, 2.0 * M_PI * i / kHeadings});
  }
  // Removes factors that cannot be evaluated at any of the headings: every solution would fail.
  void ExcludeFaulty() {
    Add(/*robust=*/false);
    std::vector<int> faults(factors_.size(), 0);
    for (int i = 0; i < kHeadings; ++i) {
      graph_.SetValue(T_FW_, Heading(i));
      for (std::size_t f = 0; f < factors_.size(); ++f) {
        if (!graph_.FaultOf(factors_[f].id).empty()) ++faults[f];
      }
    }
    std::size_t f = 0;
    std::erase_if(factors_, [&](const Factor& factor) {
      if (faults[f++] < kHeadings) return false;
      graph_.RemoveFactor(factor.id);
      return true;
    });
  }

  struct Factor {
    std::shared_ptr<ceres::CostFunction> cost;
    std::shared_ptr<ceres::LossFunction> loss;
    std::vector<VariableId> variables;
    FactorId id;  // empty until it is added
  };

  VariableId PoseOf(const Map& map, KeyFrameId id) {
    const auto [found, is_new] = poses_.try_emplace(id);
    if (is_new) {
      found->second = graph_.AddVariable(map.keyframe(id)->T_WC);
      graph_.Fix(found->second);
    }
    return found->second;
  }

  void Add(bool robust) {
    for (Factor& factor : factors_) {
      if (factor.id != FactorId()) graph_.RemoveFactor(factor.id);
      factor.id =
          graph_.AddFactorToBlocks(factor.cost, robust ? factor.loss : nullptr, factor.variables);
    }
  }

  const bool upright_;
  FactorGraph graph_;
  const Variable<Pose> T_FW_;
  std::map<KeyFrameId, VariableId> poses_;
  std::vector<Factor> factors_;
};

}  // namespace

std::optional<Pose> AlignFrame(const Map& map, ReferenceFrameId frame, SubmapId submap,
                               double max_angle) {
  Alignment alignment(map, frame, submap);
  if (alignment.IsEmpty() || !alignment.Solve() || !(alignment.AngleSigma() <= max_angle)) {
    return std::nullopt;
  }
  return alignment.value();
}

}  // namespace highwall
