#include <highwall/factors/adaptive_imu_weight.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

void RequireRamp(const MotionRamp& ramp, const char* name) {
  HIGHWALL_REQUIRE(std::isfinite(ramp.slow) && std::isfinite(ramp.rapid) && ramp.slow != ramp.rapid,
                   std::string(name) + " needs two different ends");
}

// Returns the standard normal quantile by bisection of erfc: exact to rounding, called rarely.
double NormalQuantile(double probability) {
  double low = -40.0, high = 40.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

MotionMeasures MeasureMotion(std::span<const ImuSample> samples, const ImuBias& bias) {
  HIGHWALL_REQUIRE(!samples.empty(), "MeasureMotion: there must be at least one sample");
  const double n = static_cast<double>(samples.size());
  double rate2 = 0.0, mean = 0.0, variance = 0.0;
  for (const ImuSample& sample : samples) {
    rate2 += (sample.gyroscope - bias.head<3>()).squaredNorm() / n;
    mean += (sample.accelerometer - bias.tail<3>()).norm() / n;
  }
  for (const ImuSample& sample : samples) {
    const double d = (sample.accelerometer - bias.tail<3>()).norm() - mean;
    variance += d * d / n;
  }
  MotionMeasures measures;
  measures.angular_rate = std::sqrt(rate2);          // Eq. 1
  measures.accelerometer_std = std::sqrt(variance);  // Eq. 1
  return measures;
}

double MotionRamp::operator()(double x) const {
  if (!std::isfinite(x)) return 1.0;
  return std::clamp((x - slow) / (rapid - slow), 0.0, 1.0);
}

void PaperImuWeightOptions::Validate() const {
  RequireWithin(weight_at_rest, 1e-9, 1.0, "PaperImuWeightOptions::weight_at_rest");
  RequireWithin(weight_slow, weight_at_rest, 1.0, "PaperImuWeightOptions::weight_slow");
  RequireWithin(weight_rapid, weight_slow, 1.0, "PaperImuWeightOptions::weight_rapid");
  RequireWithin(weight_max, weight_rapid, 1.0, "PaperImuWeightOptions::weight_max");
  RequireRamp(angular_rate, "PaperImuWeightOptions::angular_rate");
  RequireRamp(accelerometer_std, "PaperImuWeightOptions::accelerometer_std");
  RequireRamp(sharpness, "PaperImuWeightOptions::sharpness");
  RequireRamp(tracked_share, "PaperImuWeightOptions::tracked_share");
  RequireWithin(hysteresis, 0.0, 0.2, "PaperImuWeightOptions::hysteresis");
  RequireWithin(max_change, 1e-9, 1.0, "PaperImuWeightOptions::max_change");
}

PaperImuWeight::PaperImuWeight(const PaperImuWeightOptions& options)
    : options_(options), weight_(options.weight_at_rest) {
  options_.Validate();
}

double PaperImuWeight::Activity(const MotionMeasures& measures) const {
  return std::max({options_.angular_rate(measures.angular_rate),
                   options_.accelerometer_std(measures.accelerometer_std),
                   options_.sharpness(measures.sharpness),
                   options_.tracked_share(measures.tracked_share)});  // Eq. 2
}

double PaperImuWeight::WeightOf(double activity) const {
  // Slow motion is the lowest quarter of the activity, rapid motion the highest; a smooth step
  // connects them.
  constexpr double kSlow = 0.25, kRapid = 0.75;
  const double a = std::clamp(activity, 0.0, 1.0);
  const auto& o = options_;
  if (a <= kSlow) return o.weight_at_rest + (o.weight_slow - o.weight_at_rest) * a / kSlow;
  if (a >= kRapid) {
    return o.weight_rapid + (o.weight_max - o.weight_rapid) * (a - kRapid) / (1.0 - kRapid);
  }
  const double s = (a - kSlow) / (kRapid - kSlow);
  return o.weight_slow + (o.weight_rapid - o.weight_slow) * s * s * (3.0 - 2.0 * s);  // Eq. 3
}

double PaperImuWeight::Update(const MotionMeasures& measures) {
  const double activity = Activity(measures);
  if (!started_) {
    started_ = true;
    activity_ = activity;
    return weight_ = WeightOf(activity);
  }
  // Eq. 4: dead band (backlash), within which the activity has no effect.
  activity_ = std::clamp(activity_, activity - options_.hysteresis, activity + options_.hysteresis);
  const double change = WeightOf(activity_) - weight_;
  weight_ += std::clamp(change, -options_.max_change, options_.max_change);  // Eq. 5
  return weight_;
}

void ConsistentImuWeightOptions::Validate() const {
  RequireAtLeast(window, 1, "ConsistentImuWeightOptions::window");
  RequireWithin(inflate_above, 0.5, 1.0 - 1e-9, "ConsistentImuWeightOptions::inflate_above");
  RequireWithin(release_below, 1e-9, inflate_above, "ConsistentImuWeightOptions::release_below");
  RequireWithin(max_inflation, 1.0 + 1e-9, 1e9, "ConsistentImuWeightOptions::max_inflation");
  RequireWithin(max_ratio, 1.0 + 1e-9, 1e9, "ConsistentImuWeightOptions::max_ratio");
}

ConsistentImuWeight::ConsistentImuWeight(const ConsistentImuWeightOptions& options)
    : options_(options) {
  options_.Validate();
}

double ConsistentImuWeight::Update(double squared_innovation, int dof) {
  HIGHWALL_REQUIRE(std::isfinite(squared_innovation) && squared_innovation >= 0.0,
                   "ConsistentImuWeight: squared_innovation must be finite and not negative, is " +
                       FixedText(squared_innovation));
  HIGHWALL_REQUIRE(dof > 0, "ConsistentImuWeight: dof must be positive");
  window_.push_back({squared_innovation, dof});
  if (static_cast<int>(window_.size()) > options_.window) window_.pop_front();
  double sum = 0.0;
  int dofs = 0;
  for (const Innovation& innovation : window_) {
    sum += innovation.squared;
    dofs += innovation.dof;
  }
  // Eq. 6; between the two bounds the state is kept.
  if (sum > ChiSquaredQuantile(options_.inflate_above, dofs)) inflated_ = true;
  if (sum < ChiSquaredQuantile(options_.release_below, dofs)) inflated_ = false;
  const double inflation = inflated_ ? std::clamp(sum / dofs, 1.0, options_.max_inflation) : 1.0;
  weight_ = std::clamp(1.0 / inflation, weight_ / options_.max_ratio,
                       weight_ * options_.max_ratio);  // Eq. 7
  return weight_;
}

double ChiSquaredQuantile(double probability, int dof) {
  HIGHWALL_REQUIRE(
      probability > 0.0 && probability < 1.0,
      "ChiSquaredQuantile: the probability must lie in (0, 1), is " + FixedText(probability));
  HIGHWALL_REQUIRE(dof > 0, "ChiSquaredQuantile: dof must be positive");
  const double c = 2.0 / (9.0 * dof);
  const double root = std::max(0.0, 1.0 - c + NormalQuantile(probability) * std::sqrt(c));
  return dof * root * root * root;
}

}  // namespace highwall
