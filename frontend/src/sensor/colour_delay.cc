#include "sensor/colour_delay.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include <highwall/core/stamp.h>

#include "features/row_times.h"

namespace highwall {
namespace {

constexpr std::size_t kLatest = 4;  // [images]
constexpr double kOldest = 0.2;     // [s] since a depth image that may be that of the colour
// [s] Colour that repeats no image for so long, five images at 30 Hz, is no longer late.
constexpr double kCaughtUp = 0.17;
// Difference of Error() by which a delay must be better than the usual one: where the camera hardly
// moves, it differs by up to a tenth among delays.
constexpr double kDistinct = 0.14;
// [grey levels^2], [sigma^2] Errors below these are those of rounding.
constexpr double kLeastGrey = 0.5, kLeastPlane = 0.05;
// [cells] Motion between two depth images below which they are too alike to tell which one it is.
constexpr double kLeastMotion = 1.0;
// [m, rad] A step that ends a stage: only errors are compared, and the next step changes no choice.
constexpr double kSmallStep = 3e-4;
// Readings on patches with an error of one sigma, which are added: few readings decide nothing.
constexpr double kExpected = 10.0;

}  // namespace

ColourDelay::ColourDelay(const RgbdSensor& sensor, const DepthGrid& grid)
    : sensor_(sensor),
      grid_(grid),
      aligner_(grid, sensor.depth_noise, kMinGreyCorrelation, 0, kSmallStep) {}

void ColourDelay::Apply(bool repeated, const Twist& motion, RgbdImage* image) {
  if (repeated) {
    ++repeated_;
    repeated_at_ = image->stamp;
  }
  Remember(*image);
  if (repeated) return;
  late_ = Find(*image, motion);
  delay_ = late_ > 0 ? Age(late_) : 0;
  repeated_ = 0;
  reference_stamp_ = image->stamp;
  if (late_ == 0) return;
  const RgbdImage& depth = newest_[late_];
  image->depth = depth.depth;
  image->noise_factor = depth.noise_factor;
  if (depth.depth_stamp) image->depth_stamp = image->stamp + (*depth.depth_stamp - depth.stamp);
}

void ColourDelay::Remember(const RgbdImage& image) {
  if (ToSeconds(image.stamp - repeated_at_) > kOldest) {
    newest_.clear();
    return;
  }
  newest_.push_front({.stamp = image.stamp,
                      .bgr = {},
                      .depth = image.depth.clone(),
                      .depth_stamp = image.depth_stamp,
                      .noise_factor = image.noise_factor.clone()});
  while (newest_.size() > kLatest + 1 || ToSeconds(Age(newest_.size() - 1)) > kOldest) {
    newest_.pop_back();
  }
}

void ColourDelay::SetReference(std::shared_ptr<const FrameFeatures> features) {
  reference_ = std::move(features);
}

std::size_t ColourDelay::Find(const RgbdImage& image, const Twist& motion) const {
  if (repeated_ == 0 && late_ == 0) return 0;
  if (!reference_ || reference_->depth_grid.empty()) return 0;
  if (newest_.empty() || ToSeconds(image.stamp - repeated_at_) > kCaughtUp) return 0;
  const std::size_t latest = newest_.size() - 1;
  const std::size_t usual = std::min(latest, std::max<std::size_t>(late_, repeated_ > 0 ? 1 : 0));
  if (latest == 0 || Shift(motion) < kLeastMotion) return usual;
  cv::Mat gray;
  cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
  const cv::Mat gray_grid = grid_.Average(gray);
  std::optional<Pose> T_RC;
  const std::optional<double> as_usual = Error(gray_grid, usual, motion, &T_RC);
  std::size_t best = usual;
  std::optional<double> least;
  if (as_usual) least = *as_usual - kDistinct;
  const auto is_better = [&](std::size_t late) {
    const std::optional<double> error = Error(gray_grid, late, motion, &T_RC);
    if (!error || (least && *error >= *least)) return false;
    least = error;
    best = late;
    return true;
  };
  // Colour becomes later by repeated images alone, and catches up once there are none.
  const std::size_t most = std::min(latest, late_ + repeated_);
  for (std::size_t late = usual + 1; late <= most && is_better(late);) ++late;
  if (best == usual && (repeated_ == 0 || late_ < usual)) {
    for (std::size_t late = usual; late > 0 && is_better(late - 1);) --late;
  }
  return best;
}

double ColourDelay::Shift(const Twist& motion) const {
  const double depth = MedianDepth(*reference_);
  if (!(depth > 0.0)) return 0.0;
  return grid_.camera().fx * (motion.omega.norm() + motion.v.norm() / depth) * ToSeconds(Age(1));
}

Stamp ColourDelay::Age(std::size_t late) const {
  return newest_.front().stamp - newest_[late].stamp;
}

std::optional<double> ColourDelay::Error(const cv::Mat& gray_grid, std::size_t late,
                                         const Twist& motion, std::optional<Pose>* T_RC) const {
  FrameFeatures features;
  features.gray_grid = gray_grid;
  features.depth_grid = grid_.Sample(newest_[late].depth, sensor_.min_depth, sensor_.max_depth);
  const double since = ToSeconds(newest_.front().stamp - reference_stamp_ - Age(late) + delay_);
  const auto aligned =
      aligner_.Align(*reference_, reference_->depth_grid, Pose(), features,
                     *T_RC ? **T_RC : motion.Over(std::max(since, 0.0)),
                     *T_RC ? AlignmentStart::kAligned : AlignmentStart::kPredicted);
  if (!aligned) return std::nullopt;
  *T_RC = aligned->pose.T_WC;
  const double planes = aligned->planes;
  const double plane_error = (planes * aligned->plane_error + kExpected) / (planes + kExpected);
  return std::log(std::max(aligned->grey_error, kLeastGrey)) +
         std::log(std::max(plane_error, kLeastPlane)) - 2.0 * std::log(aligned->overlap);
}

}  // namespace highwall
