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

// A map made of cells (blocks or bricks, by code) of which a region can be filled again, in a copy
// beside it.
class RefillableMap {
 public:
  virtual ~RefillableMap() = default;
  // The cells that keyframe `id` touches from there.
  virtual Codes Touched(std::int64_t id, const Pose& T_WC) = 0;
  // Begins an empty copy.
  virtual void BeginCopy() = 0;
  // Adds a keyframe to the copy, in the cells of the region alone; null: everywhere. Returns what
  // Touched() does.
  virtual Codes AddToCopy(std::int64_t id, const Pose& T_WC, const Codes* region) = 0;
  // Puts the copy in the place of these cells; null: of the whole map.
  virtual void PutInPlace(const Codes* region) = 0;
};

// The books of a map that follows its keyframes: where each should be, where the map has it, and
// the cells that it touches there. Run() makes the map right in rounds: the cells that moved
// keyframes touched or touch are filled again from all keyframes that touch them, in the order of
// ids; from half of the keyframes on the whole map is.
class KeyframeRounds {
 public:
  // A keyframe that moved less than both stays where it is. [m], [rad]
  KeyframeRounds(double min_translation, double min_rotation)
      : min_translation_(min_translation), min_rotation_(min_rotation) {}

  // Where it should be; empty for a keyframe that is not known.
  std::optional<Pose> PoseOf(std::int64_t id) const;
  // Whether every keyframe has a smaller id, or this one.
  bool IsLast(std::int64_t id) const { return places_.upper_bound(id) == places_.end(); }
  // Says where a keyframe, be it new, should be.
  void SetPose(std::int64_t id, const Pose& T_WC) { places_[id].T_WC = T_WC; }
  // The map has it there.
  void Join(std::int64_t id, Codes cells);
  // Ends the round. Does nothing where there is no such keyframe.
  void Remove(std::int64_t id);
  void Clear();

  // Whether the map has all keyframes where they should be.
  bool IsCurrent() const;
  // Whether the next round, or this one, fills the whole map again.
  bool MovesAll() const;
  // Works for `budget` or one keyframe, whichever takes longer. True once the map is right. A pose
  // that changes meanwhile waits for the next round.
  bool Run(RefillableMap& map, std::chrono::duration<double> budget);
  // Of the lists of cells.
  std::size_t MemoryBytes() const;

 private:
  struct Place {
    Pose T_WC;
    std::optional<Pose> T_WC_in_map;
    Codes cells;  // there, ascending
  };
  struct Move {
    Pose T_WC;
    Codes cells;
  };
  struct Round {
    bool whole = false;  // the region is all of the map
    Codes region;
    std::map<std::int64_t, Move> moves;
    std::size_t surveyed = 0;  // moves whose cells are in the region
    std::int64_t next = std::numeric_limits<std::int64_t>::min();
  };

  bool HasMoved(const Place& place) const;
  void Start(RefillableMap& map);
  // One keyframe; false when there is nothing left to do but Finish().
  bool Step(RefillableMap& map);
  void Finish(RefillableMap& map);

  double min_translation_, min_rotation_;
  std::map<std::int64_t, Place> places_;
  Codes orphaned_;  // cells of keyframes that are no more
  std::optional<Round> round_;
};

}  // namespace highwall::internal
