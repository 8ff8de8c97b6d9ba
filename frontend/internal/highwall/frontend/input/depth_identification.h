#pragma once

#include <optional>
#include <vector>

#include <highwall/frontend/input/depth_survey.h>
#include <highwall/frontend/input/sensor_profile.h>

namespace [[gnu::visibility("default")]] highwall {

// A sensor that depth images may be from, and the scale of the stored values.
struct DepthGuess {
  const SensorProfile* profile = nullptr;
  double depth_factor = 0.0;  // [1/m]
  double probability = 0.0;   // among all guesses
};

// Returns which of SensorProfiles() the images may be from, most probable first, by the physics of
// depth: the steps of inverse depth that triangulation has and time of flight has not, the unit of
// the stored values, range, grain and holes. Among them is the profile "generic" for any other
// sensor, so that a poor fit is not the best for lack of others. known_factor [1/m]: one that such
// a sensor may have besides the usual ones; 0: none. Empty if the images show no sensor-specific
// pattern (all of one depth, none at all). docs/sensors.md has the likelihoods.
std::vector<DepthGuess> IdentifyDepthSensor(const DepthStatistics& statistics,
                                            double known_factor = 0.0);

// Returns the total probability of all guesses with this depth factor to within 6 %: individual
// cameras, and conversions that correct their scale, differ by as much.
double ProbabilityOfFactor(const std::vector<DepthGuess>& guesses, double depth_factor);

}  // namespace highwall
