#include "keyframe_rounds.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <highwall/internal/stopwatch.h>

namespace highwall::internal {
namespace {

// A smaller motion does not move a keyframe in the map.
constexpr double kMinMapTranslation = 0.01;           // [m]
constexpr double kMinMapRotation = 0.5 * 0.01745329;  // [rad]

}  // namespace

std::optional<Pose> KeyframeRounds::PoseOf(std::int64_t id) const {
  const auto place = places_.find(id);
  return place == places_.end() ? std::nullopt : std::optional(place->second.T_WC);
}

void KeyframeRounds::Join(std::int64_t id, Codes cells) {
  Place& place = places_.at(id);
  place.T_WC_in_map = place.T_WC;
  place.cells = std::move(cells);
}

void KeyframeRounds::Remove(std::int64_t id) {
  const auto place = places_.find(id);
  if (place == places_.end()) return;
  orphaned_ = Union(orphaned_, place->second.cells);
  places_.erase(place);
  round_.reset();
}

void KeyframeRounds::Clear() {
  places_.clear();
  orphaned_.clear();
  round_.reset();
}

bool KeyframeRounds::HasMoved(const Place& place) const {
  if (!place.T_WC_in_map) return true;
  const Pose moved = place.T_WC_in_map->Inverse() * place.T_WC;
  return moved.p().norm() > kMinMapTranslation || moved.Angle() > kMinMapRotation;
}

bool KeyframeRounds::IsCurrent() const {
  return orphaned_.empty() && std::ranges::none_of(places_, [this](const auto& entry) {
           return HasMoved(entry.second);
         });
}

bool KeyframeRounds::MovesAll() const {
  if (round_) return round_->whole;
  const auto moved =
      std::ranges::count_if(places_, [this](const auto& entry) { return HasMoved(entry.second); });
  return moved > 0 && 2 * static_cast<std::size_t>(moved) >= places_.size();
}

std::size_t KeyframeRounds::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, place] : places_) {
    bytes += sizeof(place) + place.cells.size() * sizeof(std::uint64_t);
  }
  return bytes;
}

void KeyframeRounds::Start(RefillableMap& map) {
  map.BeginCopy();
  round_ = Round();
  round_->region = orphaned_;
  for (const auto& [id, place] : places_) {
    if (!HasMoved(place)) continue;
    round_->moves[id].T_WC = place.T_WC;
    round_->region = Union(round_->region, place.cells);
  }
  round_->whole = 2 * round_->moves.size() >= places_.size();
}

bool KeyframeRounds::Step(RefillableMap& map) {
  Round& round = *round_;
  if (!round.whole && round.surveyed < round.moves.size()) {
    auto& [id, move] = *std::next(round.moves.begin(), static_cast<std::ptrdiff_t>(round.surveyed));
    move.cells = map.Touched(id, move.T_WC);
    round.region = Union(round.region, move.cells);
    ++round.surveyed;
    return true;
  }
  for (auto entry = places_.lower_bound(round.next); entry != places_.end(); ++entry) {
    const auto& [id, place] = *entry;
    const auto move = round.moves.find(id);
    const bool moved = move != round.moves.end();
    if (!moved && !place.T_WC_in_map) continue;  // added after the round began
    const Codes& cells = moved ? move->second.cells : place.cells;
    if (!round.whole && !Intersect(cells, round.region)) continue;
    Codes touched = map.AddToCopy(id, moved ? move->second.T_WC : *place.T_WC_in_map,
                                  round.whole ? nullptr : &round.region);
    if (moved) move->second.cells = std::move(touched);
    if (id == std::numeric_limits<std::int64_t>::max()) return false;
    round.next = id + 1;
    return true;
  }
  return false;
}

void KeyframeRounds::Finish(RefillableMap& map) {
  map.PutInPlace(round_->whole ? nullptr : &round_->region);
  for (auto& [id, move] : round_->moves) {
    Place& place = places_.at(id);
    place.T_WC_in_map = move.T_WC;
    place.cells = std::move(move.cells);
  }
  orphaned_.clear();
  round_.reset();
}

bool KeyframeRounds::Run(RefillableMap& map, std::chrono::duration<double> budget) {
  const Stopwatch stopwatch;
  while (round_ || !IsCurrent()) {
    if (!round_) Start(map);
    if (!Step(map)) Finish(map);
    if (stopwatch.Seconds() >= budget.count()) break;
  }
  return !round_ && IsCurrent();
}

}  // namespace highwall::internal
