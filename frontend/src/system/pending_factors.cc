#include "system/pending_factors.h"

#include <algorithm>
#include <utility>

namespace highwall {

void PendingFactors::Attach(const std::vector<PosedFrame>& frames, Map* map) {
  if (waiting_.empty() || frames.empty()) return;
  const Stamp newest = frames.back().stamp;
  std::erase_if(waiting_, [&](const PoseFactor& factor) {
    if (factor.stamps.back() > newest) return false;
    FactorCounts& counts = of_source_[factor.source];
    std::optional<MapFactor> made = MakeFactor(factor, frames, *map);
    ++(made && map->AddFactor(*std::move(made)) ? counts.attached : counts.refused);
    return true;
  });
}

std::map<std::string, FactorCounts> PendingFactors::BySource(const UserFactors& in_map) const {
  std::map<std::string, FactorCounts> counts = of_source_;
  for (const PoseFactor& factor : waiting_) ++counts[factor.source].waiting;
  for (const auto& [source, dropped] : in_map.dropped()) counts[source].dropped = dropped;
  return counts;
}

FactorCounts PendingFactors::Counts(const UserFactors& in_map) const {
  FactorCounts all;
  for (const auto& [source, counts] : BySource(in_map)) {
    all.waiting += counts.waiting;
    all.attached += counts.attached;
    all.refused += counts.refused;
    all.dropped += counts.dropped;
  }
  return all;
}

std::optional<MapFactor> PendingFactors::MakeFactor(const PoseFactor& factor,
                                                    const std::vector<PosedFrame>& frames,
                                                    const Map& map) const {
  MapFactor made{{}, factor.frame, factor.cost, factor.loss, factor.source};
  for (const Stamp stamp : factor.stamps) {
    const std::optional<AnchoredBodyPose> pose = PoseAt(stamp, frames, map);
    if (!pose) return std::nullopt;
    if (!made.poses.empty() && map.RootOf(pose->keyframe) != map.RootOf(made.poses[0].keyframe)) {
      return std::nullopt;
    }
    made.poses.push_back(*pose);
  }
  return made;
}

std::optional<AnchoredBodyPose> PendingFactors::PoseAt(Stamp stamp,
                                                       const std::vector<PosedFrame>& frames,
                                                       const Map& map) const {
  const auto after =
      std::ranges::lower_bound(frames, stamp, {}, [](const PosedFrame& f) { return f.stamp; });
  if (after == frames.end()) return std::nullopt;
  if (after->stamp == stamp) {
    return AnchoredBodyPose{after->pose.reference, after->pose.T_reference_C * T_CB_};
  }
  if (after == frames.begin()) return std::nullopt;
  const PosedFrame& before = *std::prev(after);
  const double gap = ToSeconds(after->stamp - before.stamp);
  if (gap > max_gap_ || map.RootOf(before.pose.reference) != map.RootOf(after->pose.reference)) {
    return std::nullopt;
  }
  const double share = ToSeconds(stamp - before.stamp) / gap;
  const Pose a = before.pose.T_WC(map), b = after->pose.T_WC(map);
  const Pose T_WC(a.q().slerp(share, b.q()), a.p() + share * (b.p() - a.p()));
  const AnchoredPose pose =
      AnchoredPose::At(map, (share < 0.5 ? before : *after).pose.reference, T_WC);
  return AnchoredBodyPose{pose.reference, pose.T_reference_C * T_CB_};
}

}  // namespace highwall
