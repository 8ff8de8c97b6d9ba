#pragma once

namespace highwall::simulate {

// The true noise of a sensor over that of its data sheet, which is all that an estimator is told:
// a median part on a bench. Allan deviations of D435i cameras that were published run from 0.5 to 3.2
// times it (gyroscope) and from 0.6 to 6.6 times (accelerometer); this is about their geometric
// mean. docs/simulator.md, "Truth and data sheet".
inline constexpr double kUsualNoiseRatio = 1.5;

}  // namespace highwall::simulate
