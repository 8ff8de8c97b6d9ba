#include <highwall/frontend/map/user_factors.h>

#include <algorithm>
#include <functional>
#include <string>

#include <ceres/cost_function.h>

#include <highwall/core/error.h>

namespace highwall {
namespace {

bool IsMotionWithinOneKeyFrame(const MapFactor& factor) {
  return factor.frame == kNoId && factor.poses.size() > 1 &&
         std::ranges::all_of(factor.poses, [&](const AnchoredBodyPose& pose) {
           return pose.keyframe == factor.poses.front().keyframe;
         });
}

}  // namespace

void PoseFactor::Validate() const {
  HIGHWALL_REQUIRE(cost != nullptr, "PoseFactor::cost must not be null");
  HIGHWALL_REQUIRE(!stamps.empty(), "PoseFactor::stamps must not be empty");
  HIGHWALL_REQUIRE(std::ranges::is_sorted(stamps, std::less_equal<>()),
                   "PoseFactor: the stamps must ascend, each once");
  HIGHWALL_REQUIRE(stamps.front() >= -kMaxStamp && stamps.back() <= kMaxStamp,
                   "PoseFactor: a stamp is beyond 146 years: check the clock's unit (ns)");
  const std::vector<std::int32_t>& sizes = cost->parameter_block_sizes();
  const std::size_t blocks = stamps.size() + (frame != kNoId ? 1 : 0);
  HIGHWALL_REQUIRE(sizes.size() == blocks && std::ranges::count(sizes, Pose::kSize) ==
                                                 static_cast<std::ptrdiff_t>(blocks),
                   "PoseFactor: the cost must have " + std::to_string(blocks) +
                       " blocks of 7: a pose T_WB for each stamp, and T_FW where there is a frame");
}

ReferenceFrameId UserFactors::AddFrame(const ReferenceFrame& frame) {
  frames_.push_back({frame, {}});
  return ReferenceFrameId(frames_.size() - 1);
}

void UserFactors::Add(MapFactor factor) {
  if (IsMotionWithinOneKeyFrame(factor)) {
    ++dropped_[factor.source];
  } else {
    factor.number = ++added_;
    factors_.push_back(std::move(factor));
  }
}

const UserFactors::Frame& UserFactors::At(ReferenceFrameId id) const {
  HIGHWALL_REQUIRE(id.index() < frames_.size(), "UserFactors: there is no such frame");
  return frames_[id.index()];
}

const ReferenceFrame& UserFactors::frame(ReferenceFrameId id) const {
  return At(id).frame;
}

std::optional<Pose> UserFactors::T_FW(ReferenceFrameId id, SubmapId root) const {
  const auto& places = At(id).T_FW;
  const auto found = places.find(root);
  return found != places.end() ? std::optional(found->second) : std::nullopt;
}

void UserFactors::Place(ReferenceFrameId id, SubmapId root, const Pose& T_FW) {
  (void)At(id);  // throws if there is none
  frames_[id.index()].T_FW[root] = T_FW;
}

std::map<ReferenceFrameId, Pose> UserFactors::PlacesIn(SubmapId root) const {
  std::map<ReferenceFrameId, Pose> places;
  for (const ReferenceFrameId id : frames()) {
    if (const auto place = T_FW(id, root)) places.emplace(id, *place);
  }
  return places;
}

std::vector<ReferenceFrameId> UserFactors::frames() const {
  std::vector<ReferenceFrameId> ids;
  for (std::size_t i = 0; i < frames_.size(); ++i) ids.emplace_back(i);
  return ids;
}

void UserFactors::Carry(KeyFrameId from, KeyFrameId to, const Pose& T_to_from) {
  for (MapFactor& factor : factors_) {
    for (AnchoredBodyPose& pose : factor.poses) {
      if (pose.keyframe == from) pose = {to, T_to_from * pose.T_KB};
    }
  }
  std::erase_if(factors_, [&](const MapFactor& factor) {
    if (!IsMotionWithinOneKeyFrame(factor)) return false;
    ++dropped_[factor.source];
    return true;
  });
}

void UserFactors::Remove(KeyFrameId keyframe) {
  std::erase_if(factors_, [&](const MapFactor& factor) {
    return std::ranges::any_of(
        factor.poses, [&](const AnchoredBodyPose& pose) { return pose.keyframe == keyframe; });
  });
}

void UserFactors::Transform(SubmapId root, const Pose& T_new_old) {
  for (Frame& frame : frames_) {
    const auto found = frame.T_FW.find(root);
    if (found != frame.T_FW.end()) found->second = found->second * T_new_old.Inverse();
  }
}

void UserFactors::Join(SubmapId root, SubmapId other) {
  for (Frame& frame : frames_) {
    const auto found = frame.T_FW.find(other);
    if (found == frame.T_FW.end()) continue;
    frame.T_FW.emplace(root, found->second);
    frame.T_FW.erase(other);
  }
}

}  // namespace highwall
