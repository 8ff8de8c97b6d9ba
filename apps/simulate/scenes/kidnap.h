#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "simulate/camera/simulation.h"

// Recordings in parts: the camera sees one place, then one that it has not seen, and nothing tells
// how it came there.
namespace highwall::simulate {

// A time of a simulation, in [s] since its first frame.
struct Interval {
  double begin = 0.0, end = 0.0;  // end excluded

  bool Contains(double t) const { return t >= begin && t < end; }
};

struct PartedSimulation {
  Simulation simulation;
  // The ways from one part to the next. A sequence that leaves them out or hides them is of a
  // camera that was kidnapped; one that shows them is of the same walk without.
  std::vector<Interval> ways;

  // Of which part a time [s] since the first frame is: 0, 1, ...; none on a way.
  std::optional<int> PartAt(double t) const;
};

// How the camera of a kidnap comes to see again what it saw first.
enum class WayBack {
  kOnward,   // round the rest of the room
  kReturn,   // back the way that it was carried
  kPutBack,  // carried once more, into the midst of the first part, and on to the second one
};
// Of a seed: all of them occur.
WayBack WayBackOf(std::uint64_t seed);

// In the room: 6 to 8 s of one part of it; 3 s or 4 s of way; 5 to 8 s of another part that has
// not been seen; then some 8 s until the first is seen again. Beginning, direction, parts and paths
// vary with the seed. options.duration is not used. Throws InvalidArgument.
PartedSimulation SimulateKidnap(const SimulationOptions& options);

// 11 to 13 s in one of the rooms of MakeTwinRooms(), 3.2 s from one to the other (through the
// walls: not to be shown), 11 to 13 s in the other. Likewise.
PartedSimulation SimulateTwinRooms(const SimulationOptions& options);

}  // namespace highwall::simulate
