#pragma once

#include <deque>
#include <span>

#include <highwall/factors/imu_preintegration.h>

// The weight of the inertial residuals beside the visual ones, E = E_visual + w E_IMU
// (docs/equations.md, section 4; Xiao et al. 2025, section 3.4). Two policies, each called once an
// interval between images; its result is the weight argument of ImuFactor.
namespace [[gnu::visibility("default")]] highwall {

// What the paper's policy knows of an interval between two images.
struct MotionMeasures {
  double angular_rate = 0.0;       // [rad/s] RMS, bias taken off
  double accelerometer_std = 0.0;  // [m/s^2] standard deviation of |accelerometer|
  double sharpness = 1.0;          // of the image, against what is usual: 1 usual, 0 blurred away
  double tracked_share = 1.0;      // of the features of the image before, in [0, 1]
};

// Fills in angular_rate and accelerometer_std. Throws InvalidArgument if there are no samples.
// docs/factors/adaptive_imu_weight.md, Eq. 1
MotionMeasures MeasureMotion(std::span<const ImuSample> samples, const ImuBias& bias);

// A ramp of one measure: 0 at `slow`, 1 at `rapid`, linear between. `rapid` may be the smaller one.
struct MotionRamp {
  double slow;
  double rapid;
  double operator()(double x) const;
};

// Of PaperImuWeight.
struct PaperImuWeightOptions {
  double weight_at_rest = 0.3;             // (0, 1]
  double weight_slow = 0.4;                // >= weight_at_rest; the end of "rest or slow motion"
  double weight_rapid = 0.7;               // >= weight_slow; the start of "rapid motion"
  double weight_max = 0.8;                 // in [weight_rapid, 1]
  MotionRamp angular_rate{0.2, 1.0};       // [rad/s]
  MotionRamp accelerometer_std{0.3, 2.0};  // [m/s^2] vibration
  MotionRamp sharpness{0.8, 0.4};          // [1] blur; falling
  MotionRamp tracked_share{0.7, 0.3};      // [1] lost features; falling
  double hysteresis = 0.1;   // [0, 0.2); half the change of activity that has no effect
  double max_change = 0.05;  // (0, 1]; of the weight from one interval to the next

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Policy *paper*: 0.3 to 0.4 at rest or in slow motion, 0.7 to 0.8 in rapid motion, vibration or
// blur, and a smooth way between, following the motion with hysteresis.
class PaperImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit PaperImuWeight(const PaperImuWeightOptions& options = {});

  // Once an interval. The first call starts where it finds the motion; from then on the weight
  // changes by max_change at most. A measure that is not finite counts as rapid motion.
  double Update(const MotionMeasures& measures);
  // The result of the latest Update; weight_at_rest before the first.
  double weight() const { return weight_; }

  // 0 (rest) to 1 (rapid): the largest of the four ramps.                                Eq. 2
  double Activity(const MotionMeasures& measures) const;
  // The weight of a steady activity: continuous, increasing.                             Eq. 3
  double WeightOf(double activity) const;

 private:
  PaperImuWeightOptions options_;
  bool started_ = false;
  double activity_ = 0.0;  // follows Activity() with play
  double weight_;
};

// Of ConsistentImuWeight.
struct ConsistentImuWeightOptions {
  int window = 10;               // >= 1 intervals; over which innovations are summed
  double inflate_above = 0.99;   // (0.5, 1); probability of the chi-squared bound
  double release_below = 0.9;    // (0, inflate_above]; where the inflation is taken back
  double max_inflation = 100.0;  // > 1; of the covariance
  double max_ratio = 1.25;       // > 1; of the weights of neighbouring intervals

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Policy *consistent*: w = 1, a maximum-likelihood estimate, unless the innovations of the latest
// intervals are larger than their covariance allows; then w = 1 / inflation of the covariance.
class ConsistentImuWeight {
 public:
  // Throws InvalidArgument on bad options.
  explicit ConsistentImuWeight(const ConsistentImuWeightOptions& options = {});

  // Once an interval. squared_innovation: r^T S^-1 r of the prediction with weight 1, S its
  // covariance; dof: rows of r, > 0. Throws InvalidArgument if it is negative or not finite.
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

// x with P(chi2 <= x) = probability for `dof` > 0 degrees of freedom, to 1 % from 3 degrees on
// (Wilson, Hilferty 1931). probability in (0, 1). Throws InvalidArgument outside.
double ChiSquaredQuantile(double probability, int dof);

}  // namespace highwall
