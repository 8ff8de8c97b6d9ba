#include "map/map_factor_io.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/factors/position.h>

namespace highwall {
namespace {

// Returns the Huber width, 0 without a loss; empty for another kind of loss.
std::optional<double> HuberOf(const ceres::LossFunction* loss) {
  if (loss == nullptr) return 0.0;
  if (dynamic_cast<const ceres::HuberLoss*>(loss) == nullptr) return std::nullopt;
  // Ceres has no getter: for large s the slope is the width over the root of s, here a power of
  // two.
  constexpr double kRoot = 0x1p60;
  double rho[3];
  loss->Evaluate(kRoot * kRoot, rho);
  return rho[1] * kRoot;
}

// Implausible values would be rejected when the file is read.
bool AreBelievable(const Eigen::Vector3d& p_G, const Eigen::Vector3d& lever_arm,
                   const Eigen::Matrix3d& sqrt_information, double huber) {
  return IsBounded(p_G) && IsBounded(lever_arm) && IsBounded(sqrt_information) &&
         IsBetween(0.0, huber, kLargest);
}

void WriteFrames(MapWriter& writer, const Map& map,
                 const std::map<SubmapId, std::int32_t>& submaps) {
  const UserFactors& factors = map.factors();
  const std::vector<SubmapId> roots = map.roots();
  writer(static_cast<std::uint32_t>(factors.frames().size()));
  for (const ReferenceFrameId id : factors.frames()) {
    writer(factors.frame(id).upright);
    const auto known = [&](SubmapId root) { return factors.T_FW(id, root).has_value(); };
    writer(static_cast<std::uint32_t>(std::ranges::count_if(roots, known)));
    for (const SubmapId root : roots) {
      if (!known(root)) continue;
      writer(submaps.at(root));
      WritePose(writer, *factors.T_FW(id, root));
    }
  }
}

void ReadFrames(MapReader& reader, std::uint32_t submaps, Map* map) {
  for (std::uint32_t i = reader.Count(5); i > 0; --i) {
    ReferenceFrame frame;
    reader(frame.upright);
    const ReferenceFrameId id = map->factors().AddFrame(frame);
    for (std::uint32_t places = reader.Count(60); places > 0; --places) {
      SubmapId root;
      reader(root);
      reader.Require(root.index() < submaps && map->Root(root) == root,
                     "a frame lies in no world of it");
      map->factors().Place(id, root, ReadPose(reader, "a frame lies nowhere"));
    }
  }
}

MapFactor ReadFactor(MapReader& reader, const Map& map) {
  MapFactor factor;
  AnchoredBodyPose pose;
  reader(pose.keyframe);
  reader.Require(map.keyframe(pose.keyframe) != nullptr, "a factor has no keyframe as its anchor");
  pose.T_KB = ReadPose(reader, "a factor's pose is none");
  factor.poses.push_back(pose);
  reader(factor.frame);
  reader.Require(factor.frame.index() < map.factors().frames().size(),
                 "a factor is measured in no frame");
  Eigen::Vector3d p_G, l;
  Eigen::Matrix3d sqrt_information;
  Doubles(reader, p_G);
  Doubles(reader, l);
  Doubles(reader, sqrt_information);
  double huber = 0.0;
  reader(huber);
  reader.Require(AreBelievable(p_G, l, sqrt_information, huber),
                 "a factor's numbers are beyond all");
  factor.cost = std::make_shared<PositionFactor>(p_G, l, sqrt_information);
  if (huber > 0.0) factor.loss = std::make_shared<ceres::HuberLoss>(huber);
  return factor;
}

}  // namespace

bool CanWrite(const MapFactor& factor) {
  const auto* position = dynamic_cast<const PositionFactor*>(factor.cost.get());
  const std::optional<double> huber = HuberOf(factor.loss.get());
  return position != nullptr && huber && factor.frame != kNoId && factor.poses.size() == 1 &&
         AreBelievable(position->p_G(), position->lever_arm(), position->sqrt_information(),
                       *huber);
}

void WriteFactors(MapWriter& writer, const Map& map,
                  const std::map<SubmapId, std::int32_t>& submaps,
                  const std::unordered_map<KeyFrameId, std::int32_t>& keyframes) {
  WriteFrames(writer, map, submaps);
  const std::vector<MapFactor>& all = map.factors().all();
  writer(static_cast<std::uint32_t>(std::ranges::count_if(all, CanWrite)));
  for (const MapFactor& factor : all) {
    if (!CanWrite(factor)) continue;
    writer(keyframes.at(factor.poses.front().keyframe));
    WritePose(writer, factor.poses.front().T_KB);
    writer(factor.frame.value());
    const auto& cost = dynamic_cast<const PositionFactor&>(*factor.cost);
    Doubles(writer, cost.p_G());
    Doubles(writer, cost.lever_arm());
    Doubles(writer, cost.sqrt_information());
    writer(*HuberOf(factor.loss.get()));
  }
}

void ReadFactors(MapReader& reader, std::uint32_t submaps, Map* map) {
  ReadFrames(reader, submaps, map);
  for (std::uint32_t i = reader.Count(192); i > 0; --i) {
    map->AddFactor(ReadFactor(reader, *map));
  }
}

}  // namespace highwall
