#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>

#include <highwall/core/pose.h>

#include "sorted_codes.h"

namespace highwall::internal {

// Map made of cells (blocks or bricks, identified by codes), a region of which can be refilled in a
// separate copy.
class RefillableMap {
 public:
  virtual ~RefillableMap() = default;
  // Returns the cells that keyframe `id` touches from T_WC.
  virtual Codes Touched(std::int64_t id, const Pose& T_WC) = 0;
  // Starts an empty copy.
  virtual void BeginCopy() = 0;
  // Adds a keyframe to the copy, only in the cells of the region (null: everywhere). Returns the
  // same as Touched().
  virtual Codes AddToCopy(std::int64_t id, const Pose& T_WC, const Codes* region) = 0;
  // Replaces the cells of the region (null: of the whole map) by the copy.
  virtual void PutInPlace(const Codes* region) = 0;
};

// State of a map that follows its keyframes: for each keyframe the target pose, the pose in the
// map, and the cells that it touches there. Run() updates the map in rounds: the cells that moved
// keyframes touched before or touch now are refilled from all keyframes that touch them, in the
// order of ids; if at least half of the keyframes moved, the whole map is refilled. A keyframe that
// moved by less than 1 cm and half a degree is not moved in the map.
class KeyframeRounds {
 public:
  // Returns the target pose; empty for an unknown keyframe.
  std::optional<Pose> PoseOf(std::int64_t id) const;
  // Returns whether no keyframe has a larger id.
  bool IsLast(std::int64_t id) const { return places_.upper_bound(id) == places_.end(); }
  // Sets the target pose of a keyframe, which may be new.
  void SetPose(std::int64_t id, const Pose& T_WC) { places_[id].T_WC = T_WC; }
  // Records that the map has the keyframe at its target pose.
  void Join(std::int64_t id, Codes cells);
  // Removes a keyframe and aborts the round; does nothing if there is no such keyframe.
  void Remove(std::int64_t id);
  void Clear();

  // Returns whether the map has all keyframes at their target poses.
  bool IsCurrent() const;
  // Returns whether the current round, or the next one if none is running, refills the whole map.
  bool MovesAll() const;
  // Works for `budget` or one keyframe, whichever takes longer. Returns true once the map is up to
  // date. A pose that changes in the meantime waits for the next round.
  bool Run(RefillableMap& map, std::chrono::duration<double> budget);
  // Returns the memory of the lists of cells in bytes.
  std::size_t MemoryBytes() const;

 private:
  struct Place {
    Pose T_WC;
    std::optional<Pose> T_WC_in_map;
    Codes cells;  // touched from T_WC_in_map, ascending
  };
  struct Move {
    Pose T_WC;
    Codes cells;
  };
  struct Round {
    bool whole = false;  // the region is the whole map
    Codes region;
    std::map<std::int64_t, Move> moves;
    std::size_t surveyed = 0;  // number of moves whose cells are in the region
    std::int64_t next = std::numeric_limits<std::int64_t>::min();
  };

  bool HasMoved(const Place& place) const;
  void Start(RefillableMap& map);
  // Processes one keyframe; returns false when only Finish() is left to do.
  bool Step(RefillableMap& map);
  void Finish(RefillableMap& map);

  std::map<std::int64_t, Place> places_;
  Codes orphaned_;  // cells of removed keyframes
  std::optional<Round> round_;
};

}  // namespace highwall::internal
