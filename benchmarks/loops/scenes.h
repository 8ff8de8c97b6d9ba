#pragma once

#include <simulate/simulation.h>

namespace highwall::bench {

// The pixels of a Kinect halved: rendering is what a benchmark would else spend its time on.
PinholeCamera SmallCamera();

// A room filmed by it at 10 Hz, in laps of at most 20 s.
simulate::Simulation MakeRoom(int seed, double seconds);

}  // namespace highwall::bench
