#pragma once

#include <optional>
#include <span>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// Overlapping Allan deviation of a sensor's readings for one averaging time.
struct AllanPoint {
  double tau = 0.0;        // [s]
  double deviation = 0.0;  // [unit of the readings]
  double freedom = 0.0;    // equivalent degrees of freedom of the squared deviation
};

// Noise density with its 95 % confidence interval.
struct NoiseDensity {
  double value = 0.0;
  double low = 0.0;  // 0 where the readings can be explained without this noise
  double high = 0.0;

  // Returns whether the density is significantly above 0; otherwise `high` is only an upper bound.
  bool IsSeen() const { return low > 0.0; }
};

// Noise components of a curve of Allan deviation.
struct NoiseDensities {
  NoiseDensity white;        // [unit / sqrt(Hz)]
  NoiseDensity instability;  // [unit] flicker noise of the bias; the curve's floor is 0.664 of it
  NoiseDensity walk;         // [unit / s / sqrt(Hz)] of the bias
};

struct AllanFitOptions {
  // [s] >= 0; shorter averaging times, affected by the sensor's internal filter, are not used
  double min_tau = 0.0;
  // >= 0; relative error of the model's curve for a real sensor, as a fraction of the deviation
  double model_error = 0.05;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Computes the Allan deviation for averaging times of 1, 2, 4, ... readings up to a third of the
// longest stretch, pooled over all stretches; no difference crosses their borders. step: [s] > 0
// between readings. Empty if no stretch has three readings. Throws InvalidArgument on a bad step
// and on readings that are not finite.
// docs/imu_noise_estimation.md, Eq. 1
std::vector<AllanPoint> AllanDeviation(std::span<const std::vector<double>> stretches, double step);

// Returns the expected deviation at tau [s] of such noise.                                    Eq. 2
double ModelledAllanDeviation(const NoiseDensities& densities, double tau);

// Estimates the noise of a curve by maximum likelihood (Eq. 4). Empty if fewer than three of its
// points can be used. Throws InvalidArgument on bad options.
//
// Source: IEEE Std 952-1997, annex C (noise of gyroscopes); Riley, "Handbook of frequency stability
// analysis", NIST Special Publication 1065, 2008 (degrees of freedom).
std::optional<NoiseDensities> FitAllanCurve(std::span<const AllanPoint> curve,
                                            const AllanFitOptions& options = {});

}  // namespace highwall
