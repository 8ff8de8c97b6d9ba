#include "map/map_factor_io.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include <ceres/loss_function.h>

#include <highwall/core/relative_pose.h>
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

bool AreBelievable(const Pose& Z, const Eigen::Matrix<double, 6, 6>& sqrt_information,
                   double huber) {
  return IsBounded(Z.p()) && IsBounded(sqrt_information) && IsBetween(0.0, huber, kLargest);
}

// Returns the cost of a position that can be written; null for any other factor.
const PositionFactor* PositionOf(const MapFactor& factor) {
  const auto* cost = dynamic_cast<const PositionFactor*>(factor.cost.get());
  const std::optional<double> huber = HuberOf(factor.loss.get());
  const bool fits = cost != nullptr && huber && factor.frame != kNoId && factor.poses.size() == 1 &&
                    AreBelievable(cost->p_G(), cost->lever_arm(), cost->sqrt_information(), *huber);
  return fits ? cost : nullptr;
}

// Returns the cost of a motion that can be written; null for any other factor.
const RelativePose* MotionOf(const MapFactor& factor) {
  const auto* cost = dynamic_cast<const RelativePose*>(factor.cost.get());
  const std::optional<double> huber = HuberOf(factor.loss.get());
  const bool fits = cost != nullptr && huber && factor.frame == kNoId && factor.poses.size() == 2 &&
                    AreBelievable(cost->Z(), cost->sqrt_information(), *huber);
  return fits ? cost : nullptr;
}

using Ranks = std::unordered_map<KeyFrameId, std::int32_t>;

void WriteAnchor(MapWriter& writer, const AnchoredBodyPose& pose, const Ranks& keyframes) {
  writer(keyframes.at(pose.keyframe));
  WritePose(writer, pose.T_KB);
}

AnchoredBodyPose ReadAnchor(MapReader& reader, const Map& map) {
  AnchoredBodyPose pose;
  reader(pose.keyframe);
  reader.Require(map.keyframe(pose.keyframe) != nullptr, "a factor has no keyframe as its anchor");
  pose.T_KB = ReadPose(reader, "a factor's pose is none");
  return pose;
}

void WritePosition(MapWriter& writer, const MapFactor& factor, const Ranks& keyframes) {
  const PositionFactor& cost = *PositionOf(factor);
  WriteAnchor(writer, factor.poses.front(), keyframes);
  writer(factor.frame.value());
  Doubles(writer, cost.p_G());
  Doubles(writer, cost.lever_arm());
  Doubles(writer, cost.sqrt_information());
  writer(*HuberOf(factor.loss.get()));
}

void WriteMotion(MapWriter& writer, const MapFactor& factor, const Ranks& keyframes) {
  const RelativePose& cost = *MotionOf(factor);
  for (const AnchoredBodyPose& pose : factor.poses) WriteAnchor(writer, pose, keyframes);
  WritePose(writer, cost.Z());
  Doubles(writer, cost.sqrt_information());
  writer(*HuberOf(factor.loss.get()));
}

std::shared_ptr<ceres::LossFunction> MakeLoss(double huber) {
  return huber > 0.0 ? std::make_shared<ceres::HuberLoss>(huber) : nullptr;
}

MapFactor ReadPosition(MapReader& reader, const Map& map) {
  MapFactor factor;
  factor.poses.push_back(ReadAnchor(reader, map));
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
  factor.loss = MakeLoss(huber);
  return factor;
}

MapFactor ReadMotion(MapReader& reader, const Map& map) {
  MapFactor factor;
  for (int i = 0; i < 2; ++i) factor.poses.push_back(ReadAnchor(reader, map));
  const Pose Z = ReadPose(reader, "a factor's motion is none");
  Eigen::Matrix<double, 6, 6> sqrt_information;
  Doubles(reader, sqrt_information);
  double huber = 0.0;
  reader(huber);
  reader.Require(AreBelievable(Z, sqrt_information, huber), "a factor's numbers are beyond all");
  factor.cost = std::make_shared<RelativePose>(Z, sqrt_information);
  factor.loss = MakeLoss(huber);
  return factor;
}

bool IsPosition(const MapFactor& factor) {
  return PositionOf(factor) != nullptr;
}

bool IsMotion(const MapFactor& factor) {
  return MotionOf(factor) != nullptr;
}

}  // namespace

bool CanWrite(const MapFactor& factor) {
  return IsPosition(factor) || IsMotion(factor);
}

bool HasMotions(const Map& map) {
  return std::ranges::any_of(map.factors().all(), IsMotion);
}

void WriteFactors(MapWriter& writer, const Map& map,
                  const std::map<SubmapId, std::int32_t>& submaps,
                  const std::unordered_map<KeyFrameId, std::int32_t>& keyframes) {
  WriteFrames(writer, map, submaps);
  const std::vector<MapFactor>& all = map.factors().all();
  writer(static_cast<std::uint32_t>(std::ranges::count_if(all, IsPosition)));
  for (const MapFactor& factor : all) {
    if (IsPosition(factor)) WritePosition(writer, factor, keyframes);
  }
  if (!HasMotions(map)) return;
  writer(static_cast<std::uint32_t>(std::ranges::count_if(all, IsMotion)));
  for (const MapFactor& factor : all) {
    if (IsMotion(factor)) WriteMotion(writer, factor, keyframes);
  }
}

void ReadFactors(MapReader& reader, std::uint32_t submaps, bool has_motions, Map* map) {
  ReadFrames(reader, submaps, map);
  for (std::uint32_t i = reader.Count(192); i > 0; --i) {
    map->AddFactor(ReadPosition(reader, *map));
  }
  if (!has_motions) return;
  for (std::uint32_t i = reader.Count(472); i > 0; --i) {
    map->AddFactor(ReadMotion(reader, *map));
  }
}

}  // namespace highwall
