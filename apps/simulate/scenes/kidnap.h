#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "simulate/camera/simulation.h"

// Recordings in parts: the camera observes one place, then a new one, without information about the
// motion in between.
namespace highwall::simulate {

// Time interval of a simulation, in [s] since its first frame.
struct Interval {
  double begin = 0.0, end = 0.0;  // end excluded

  bool Contains(double t) const { return t >= begin && t < end; }
};

struct PartedSimulation {
  Simulation simulation;
  // Transitions between the parts. A sequence that omits or hides them simulates a kidnapped
  // camera; one that shows them is the same walk without kidnapping.
  std::vector<Interval> ways;

  // Returns the part at a time [s] since the first frame: 0, 1, ...; none on a transition.
  std::optional<int> PartAt(double t) const;
};

// Path by which the kidnapped camera returns to the first place.
enum class WayBack {
  kOnward,   // round the rest of the room
  kReturn,   // back along the path of the transition
  kPutBack,  // carried again, into the middle of the first part, then to the second
};
// Returns the choice of a seed: all of them occur.
WayBack WayBackOf(std::uint64_t seed);

// Simulates a kidnapping in the room: 6 to 8 s of one part of it; 3 s or 4 s of transition; 5 to 8
// s of another, unseen part; then about 8 s until the first is seen again. Start, direction, parts
// and paths vary with the seed. options.duration is not used. Throws InvalidArgument.
PartedSimulation SimulateKidnap(const SimulationOptions& options);

// Simulates 11 to 13 s in one of the rooms of MakeTwinRooms(), 3.2 s of transition (through the
// walls: not to be shown), and 11 to 13 s in the other. Same conditions as above.
PartedSimulation SimulateTwinRooms(const SimulationOptions& options);

}  // namespace highwall::simulate
