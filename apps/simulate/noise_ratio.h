#pragma once

namespace highwall::simulate {

// True noise of a sensor relative to its data sheet, which is all that an estimator is given: the
// median of sensors on a bench. Published Allan deviations of D435i cameras range from 0.5 to 3.2
// times the data sheet (gyroscope) and from 0.6 to 6.6 times (accelerometer); this is about their
// geometric mean. docs/simulator.md, "Truth and data sheet".
inline constexpr double kUsualNoiseRatio = 1.5;

}  // namespace highwall::simulate
