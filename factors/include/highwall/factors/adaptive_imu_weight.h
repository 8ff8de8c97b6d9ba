#pragma once

#include <deque>
#include <span>

#include <highwall/factors/imu_preintegration.h>

// Weight w of the inertial residuals relative to the visual ones, E = E_visual + w E_IMU
// (docs/equations.md, section 4; Xiao et al. 2025, section 3.4). There are two policies; each is
// called once per interval between images, and its result is the weight argument of ImuFactor.
namespace [[gnu::visibility("default")]] highwall {

// Motion and image measures of an interval between two images, input of the paper's policy.
struct MotionMeasures {
  double angular_rate = 0.0;       // [rad/s] RMS of the bias-corrected rate
  double accelerometer_std = 0.0;  // [m/s^2] standard deviation of |accelerometer|
  double sharpness = 1.0;          // of the image, relative: 1 as usual, 0 fully blurred
  double tracked_share = 1.0;      // share of the previous image's features, in [0, 1]
};

// Returns the measures with angular_rate and accelerometer_std filled in. Throws InvalidArgument if
// there are no samples.
// docs/factors/adaptive_imu_weight.md, Eq. 1
MotionMeasures MeasureMotion(std::span<const ImuSample> samples, const ImuBias& bias);

// Linear ramp of one measure: 0 at `slow`, 1 at `rapid`. `rapid` may be less than `slow`.
struct MotionRamp {
  double slow;
  double rapid;
  double operator()(double x) const;
};

// Options of PaperImuWeight.
struct PaperImuWeightOptions {
  double weight_at_rest = 0.3;             // (0, 1]
  double weight_slow = 0.4;                // >= weight_at_rest; upper end of "rest or slow motion"
  double weight_rapid = 0.7;               // >= weight_slow; lower end of "rapid motion"
  double weight_max = 0.8;                 // in [weight_rapid, 1]
  MotionRamp angular_rate{0.2, 1.0};       // [rad/s]
  MotionRamp accelerometer_std{0.3, 2.0};  // [m/s^2] vibration
  MotionRamp sharpness{0.8, 0.4};          // [1] decreases with motion blur
  MotionRamp tracked_share{0.7, 0.3};      // [1] decreases with lost features
  double hysteresis = 0.1;   // [0, 0.2]; half the width of the dead band of the activity
  double max_change = 0.05;  // (0, 1]; of the weight between consecutive intervals

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Policy *paper*: the weight is 0.3 to 0.4 at rest or in slow motion and 0.7 to 0.8 in rapid
// motion, vibration or blur, with a smooth transition; it follows the motion with hysteresis.
class PaperImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit PaperImuWeight(const PaperImuWeightOptions& options = {});

  // Call once per interval. The first call initializes the weight from its measures; afterwards the
  // weight changes by at most max_change per call. A non-finite measure counts as rapid motion.
  double Update(const MotionMeasures& measures);
  // Result of the latest Update(); weight_at_rest before the first call.
  double weight() const { return weight_; }

  // Activity from 0 (rest) to 1 (rapid): the maximum of the four ramps.                    Eq. 2
  double Activity(const MotionMeasures& measures) const;
  // Weight of a constant activity: continuous, increasing.                                 Eq. 3
  double WeightOf(double activity) const;

 private:
  PaperImuWeightOptions options_;
  bool started_ = false;
  double activity_ = 0.0;  // follows Activity() with the dead band
  double weight_;
};

// Options of ConsistentImuWeight.
struct ConsistentImuWeightOptions {
  int window = 10;               // >= 1; number of intervals over which innovations are summed
  double inflate_above = 0.99;   // (0.5, 1); probability of the chi-squared bound
  double release_below = 0.9;    // (0, inflate_above]; probability below which the inflation ends
  double max_inflation = 100.0;  // > 1; of the covariance
  double max_ratio = 1.25;       // > 1; of the weights of consecutive intervals

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Policy *consistent*: w = 1 (maximum-likelihood estimate) unless the innovations of the latest
// intervals are inconsistent with their covariance; then w = 1 / (covariance inflation).
class ConsistentImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit ConsistentImuWeight(const ConsistentImuWeightOptions& options = {});

  // Call once per interval. squared_innovation: r^T S^-1 r of the prediction with weight 1, S being
  // its covariance; dof: number of rows of r, > 0. Throws InvalidArgument if squared_innovation is
  // negative or not finite, or dof not positive.
  double Update(double squared_innovation, int dof);
  double weight() const { return weight_; }  // in [1 / max_inflation, 1]
  bool IsInflated() const { return inflated_; }

 private:
  struct Innovation {
    double squared;
    int dof;
  };

  ConsistentImuWeightOptions options_;
  std::deque<Innovation> window_;
  bool inflated_ = false;
  double weight_ = 1.0;
};

// Returns x with P(chi2 <= x) = probability for `dof` > 0 degrees of freedom, accurate to 1 % from
// 3 degrees of freedom (Wilson, Hilferty 1931). probability in (0, 1). Throws InvalidArgument
// outside of these ranges.
double ChiSquaredQuantile(double probability, int dof);

}  // namespace highwall
