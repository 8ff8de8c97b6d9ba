#pragma once

#include <span>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// Overlapping Allan deviation of a sensor's readings for one averaging time.
struct AllanPoint {
  double tau = 0.0;        // [s]
  double deviation = 0.0;  // [unit of the readings]
  double freedom = 0.0;    // equivalent degrees of freedom of its square
};

// A density of noise and the range it lies in with a probability of 95 %.
struct NoiseDensity {
  double value = 0.0;
  double low = 0.0;  // 0 where the readings could do without this noise
  double high = 0.0;

  // Above 0 beyond doubt; else `high` is all that is known.
  bool IsSeen() const { return low > 0.0; }
};

// What a curve of Allan deviation is made of.
struct NoiseDensities {
  NoiseDensity white;        // [unit / sqrt(Hz)]
  NoiseDensity instability;  // [unit] flicker noise of the bias; 0.664 of it is the curve's floor
  NoiseDensity walk;         // [unit / s / sqrt(Hz)] of the bias
};

struct AllanFitOptions {
  // [s] >= 0; shorter averaging times are not used: there the sensor's own filter shows
  double min_tau = 0.0;
  // >= 0; how far the curve of a real sensor is off the model's, as a share of the deviation
  double model_error = 0.05;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// For averaging times of 1, 2, 4, ... readings up to a third of the longest stretch, of all
// stretches together; no difference is taken across their borders. step: [s] > 0 between readings.
// Empty where no stretch has three readings. Throws InvalidArgument on a bad step and on readings
// that are not finite.                                         docs/factors/allan_deviation.md, Eq.
// 1
std::vector<AllanPoint> AllanDeviation(std::span<const std::vector<double>> stretches, double step);

// The deviation at tau [s] that such noise has on average.                                    Eq. 2
double ModelledAllanDeviation(const NoiseDensities& densities, double tau);

// The most likely noise behind a curve. Throws InvalidArgument where fewer than three of its points
// are used, and on bad options.                                                               Eq. 4
//
// Source: IEEE Std 952-1997, annex C (noise of gyroscopes); Riley, "Handbook of frequency stability
// analysis", NIST Special Publication 1065, 2008 (degrees of freedom).
NoiseDensities FitAllanCurve(std::span<const AllanPoint> curve,
                             const AllanFitOptions& options = {});

}  // namespace highwall
