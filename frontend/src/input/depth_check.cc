#include <highwall/frontend/input/depth_check.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/depth_identification.h>
#include <highwall/frontend/input/depth_survey.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

#include "input/depth_bend.h"
#include "input/depth_delay.h"
#include "input/depth_edges.h"
#include "input/depth_values.h"

namespace highwall {
namespace {

constexpr std::size_t kFewImages = 8;  // at most: their means count less
constexpr int kHighest = std::numeric_limits<std::uint16_t>::max();

// [m] Median depths that are usual: with a factor of 1000 for 5000, or the reverse, another
// results.
constexpr double kUsualNear = 0.8, kUsualFar = 3.5;
// [m] Median depths that a wrong factor explains if the noise is as far from the sensor's: it grows
// with the square of depth, so that with a factor that is k times too large it is about k times
// what is stated. Right generated recordings had 0.8 to 2 times, real ones 0.3 to 0.7.
constexpr double kVeryNear = 0.6, kVeryFar = 6.0;
constexpr double kNoisy = 2.5, kCalm = 0.2;
constexpr double kLeastGrain = 0.5;  // [stored units] Rounding hides less noise.
constexpr double kSureFactor = 0.98, kImpossibleFactor = 0.005;  // probabilities
// shares of the readings in the sensor's range by a wrong factor and by the right one
constexpr double kHardlyAny = 0.2, kNearlyAllReadings = 0.95;
constexpr double kPossibleFactor = 0.2;  // probability

constexpr int kInverseImages = 4;
constexpr double kEdgesFit = 0.08;  // correlation of edges that agree
// The same on a vehicle, with few edges, where a flip fits twice as well, or a shift does by 2.5
// times and is far. On right recordings a flip fitted 0.85 times as well as the best shift, and
// shifts by up to 2 % of the width (errors of the edges of a slanted road) 2.3 times as well; depth
// that is 20 ms late was once shifted by 2.7 % in all images.
constexpr double kFewEdgesFit = 0.05, kFewEdgesShiftBetter = 2.5, kFewEdgesShift = 0.03;
// Of more images: standard deviations by which the mean is higher, if not nearly all images are.
// Images near to each other share errors: half of the evidence.
constexpr double kFitSigmas = 5.0;
// Ratio of correlations of the right flip and any other; the same of more images.
constexpr double kEdgesFitBetter = 2.0, kManyEdgesFitBetter = 1.7;
constexpr double kNearlyAlways = 0.85;  // share of the images: seven of eight
constexpr double kStable = 0.02;        // of the width: sigma of a shift
constexpr double kNearCentre = 0.05;    // of the width: shift of an image that is only mirrored
// Of the width: depth that is 20 ms late is shifted by 2.1 % where the camera turns by 1.3 rad/s
// and the focal length is 0.8 of the width.
constexpr double kShifted = 0.022;
constexpr double kFarShifted = 0.03;    // of the width
constexpr double kBesideDelay = 0.008;  // of the width, along it: what no usual delay explains
constexpr double kSigmas = 5.0;
// Another field of view: the least correlation, its ratios to those of the best shift and of the
// images as they are, the share of the images, and the change of the field if one is left out. On
// right recordings the ratios were at most 1.03 and 1.3, and once, for 5 of 8 images, 1.35 and 2.4.
constexpr double kViewFits = 0.04, kViewFitsBetter = 1.5, kViewFitsMuchBetter = 2.5;
constexpr double kMostlyView = 0.7, kStableView = 0.2;
// Ratio and difference of the correlations with the shift and without it, but with any usual delay.
constexpr double kShiftFitsBetter = 1.3, kShiftFitsAbove = 0.045;
// A delay of depth: [s] from which on it is reported, and the ratio of correlations with it and
// with any usual one. Right recordings, 20 ms late, gave up to 25 +- 3 ms, and one whose colour
// repeats 47 ms.
constexpr double kLate = 0.055, kDelayFitsBetter = 1.1;
constexpr double kDelaySigma = 0.0025;  // [s] the least standard deviation of a delay
// Share of these limits below which a few images leave no hope that more of them exceed any: what
// fits by chance fits less with more images.
constexpr double kHopeful = 0.7;

bool IsUsual(double median) {
  return median > kUsualNear && median < kUsualFar;
}

std::string Short(double value) {
  return RoundedText(value, 4);
}

std::string Percent(double share) {
  return FixedText(100.0 * share, 0) + " %";
}

// Share of the readings between these stored values, by the quantiles that are known of them.
double ShareBetween(const std::vector<double>& readings, double low, double high) {
  const auto within =
      std::ranges::count_if(readings, [&](double value) { return value >= low && value <= high; });
  return readings.empty() ? 1.0
                          : static_cast<double>(within) / static_cast<double>(readings.size());
}

// Whether the far readings leave out values between them, as steps do. The search for steps takes
// long where they fill all.
bool HasGaps(const std::vector<double>& sorted) {
  constexpr double kFilled = 0.6;  // of the values that as many readings fill by chance
  const std::size_t begin = sorted.size() / 2, end = sorted.size() - sorted.size() / 10;
  const double count = static_cast<double>(end - begin),
               range = sorted[end - 1] - sorted[begin] + 1;
  double distinct = 1.0;
  for (std::size_t i = begin + 1; i < end; ++i) distinct += sorted[i] > sorted[i - 1] ? 1.0 : 0.0;
  return distinct < kFilled * range * (1.0 - std::exp(-count / range));
}

// The highest value beyond the sensor's range stands for no reading, and has no edges.
cv::Mat Measured(const cv::Mat& raw, const RgbdSensor& sensor) {
  if (kHighest <= sensor.max_depth * sensor.depth_factor) return raw;
  cv::Mat measured = raw.clone();
  measured.setTo(0, raw == kHighest);
  return measured;
}

SensorFinding ConstantDepth(const char* text) {
  return {SensorFault::kDepthConstant, Trust::kNotTrusted, text,
          "store what the depth camera measures; a constant makes any motion look like another"};
}

SensorFinding SwappedBytes() {
  return {SensorFault::kDepthByteOrder, Trust::kNotTrusted,
          "the depth values of neighbouring pixels differ wildly, and are smooth with their two "
          "bytes exchanged",
          "store 16-bit PNG in its own byte order (cv::imwrite and the like do)"};
}

SensorFinding WrongFactor(std::string text, double factor) {
  return {SensorFault::kDepthScale, Trust::kNotTrusted, std::move(text),
          "set depth_factor: " + Short(factor) + " if the images are of that sensor"};
}

// Median over the depths of the noise of depth over what the sensor states; empty if it is unknown.
std::optional<double> NoiseRatio(const DepthStatistics& statistics, const RgbdSensor& sensor) {
  std::vector<double> ratios;
  for (const DepthGrain& grain : statistics.grain) {
    if (grain.sigma < kLeastGrain) continue;
    const double depth = grain.depth / sensor.depth_factor;
    ratios.push_back(grain.sigma / sensor.depth_factor / sensor.depth_noise.Sigma(depth));
  }
  return ratios.empty() ? std::nullopt : std::optional(UpperMedian(std::move(ratios)));
}

// The default is that of a Kinect, whatever the sensor is.
bool StatesNoise(const RgbdSensor& sensor) {
  const DepthNoise &noise = sensor.depth_noise, usual;
  return noise.offset != usual.offset || noise.quadratic != usual.quadratic ||
         noise.reference != usual.reference;
}

// Depths that are as unlikely as their noise. median: [m]
std::optional<SensorFinding> UnlikelyScale(double median, double noise, const RgbdSensor& sensor) {
  const bool is_near = median < kVeryNear && noise > kNoisy;
  // Sensors that measure so far, such as those of LiDAR, are far better than a Kinect.
  const bool is_far = median > kVeryFar && noise < kCalm && StatesNoise(sensor);
  if (!is_near && !is_far) return std::nullopt;
  return SensorFinding{SensorFault::kDepthScale, Trust::kDoubtful,
                       "half of the depth readings are " +
                           std::string(is_near ? "nearer" : "farther") + " than " +
                           FixedText(median, 2) + " m, and the noise of depth is " +
                           FixedText(noise, 2) + " times what depth_noise says",
                       std::string("check whether depth_factor is several times too ") +
                           (is_near ? "large" : "small") + ", and depth_noise"};
}

SensorFinding InverseDepth() {
  return {SensorFault::kDepthInverse, Trust::kNotTrusted,
          "planes are bent in the depth images as if the values were disparities or inverse depths",
          "store z = focal length x baseline / disparity"};
}

SensorFinding MirroredDepth(DepthFlip flip) {
  const char* const how = flip == DepthFlip::kLeftRight    ? "mirrored left to right"
                          : flip == DepthFlip::kUpsideDown ? "upside down"
                                                           : "turned by 180 degrees";
  return {SensorFault::kDepthMirrored, Trust::kNotTrusted,
          std::string("depth is ") + how + " against the colour images: their edges agree then",
          "flip the depth images"};
}

SensorFinding OtherView(double share) {
  return {SensorFault::kDepthUnregistered, Trust::kNotTrusted,
          "depth images show about " + FixedText(share, 2) +
              " of the field of view of the colour images: their edges agree then",
          "register depth to the colour camera (the camera's driver can: align, registered)"};
}

SensorFinding DelayedDepth(double delay) {
  return {
      SensorFault::kDepthInconsistent, Trust::kDoubtful,
      "depth was measured " + FixedText(1e3 * std::abs(delay), 0) + " ms " +
          (delay > 0.0 ? "after" : "before") + " the colour it is paired with: edges agree then",
      "pair each colour image with the depth image of the same moment, or correct their stamps"};
}

SensorFinding ShiftedDepth(const EdgeFit& fit, int width) {
  const double far = std::hypot(fit.shift_u, fit.shift_v);
  const auto part = [](double shift, const char* positive, const char* negative) {
    return RoundedText(std::abs(shift), 2) + " px " + (shift > 0.0 ? positive : negative);
  };
  std::string where;
  if (std::abs(fit.shift_u) > 0.3 * far) {
    where = part(fit.shift_u, "to the right of", "to the left of");
  }
  if (std::abs(fit.shift_v) > 0.3 * far) {
    where += (where.empty() ? "" : " and ") + part(fit.shift_v, "below", "above");
  }
  return {SensorFault::kDepthUnregistered,
          far > kFarShifted * width ? Trust::kNotTrusted : Trust::kDoubtful,
          "depth lies " + where + " colour: their edges agree then",
          "register depth to the colour camera (the camera's driver can: align, registered)"};
}

}  // namespace

struct DepthCheck::Tests {
  cv::Size size;
  std::vector<cv::Mat> images;  // raw
  DepthValues values;
  DepthBend bend;
  DepthEdges edges;
  DepthDelayFinder delay;
  std::vector<double> readings;  // [stored units] a sample

  // [m] By the depth factor of the sensor; empty without readings.
  std::optional<double> MedianDepth(const RgbdSensor& sensor) const;
  void AddScale(const RgbdSensor& sensor, std::vector<SensorFinding>* findings) const;
  void AddPlace(std::vector<SensorFinding>* findings) const;
  bool IsDelayed(const DelayFit& fit) const;
  // That of the edges of all images, computed once.
  const std::optional<DepthEdges::Result>& Fit() const;

 private:
  mutable std::optional<DepthEdges::Result> fit_;
  mutable std::size_t fitted_ = 0;  // images
};

const std::optional<DepthEdges::Result>& DepthCheck::Tests::Fit() const {
  if (fitted_ != images.size()) fit_ = edges.Fit();
  fitted_ = images.size();
  return fit_;
}

std::optional<double> DepthCheck::Tests::MedianDepth(const RgbdSensor& sensor) const {
  if (readings.empty()) return std::nullopt;
  return UpperMedian(readings) / sensor.depth_factor;
}

// Where the depths by the factor are usual, only steps of the values show another one.
void DepthCheck::Tests::AddScale(const RgbdSensor& sensor,
                                 std::vector<SensorFinding>* findings) const {
  if (readings.empty()) return;
  std::vector<double> sorted = readings;
  std::ranges::sort(sorted);
  const double factor = sensor.depth_factor, median = sorted[sorted.size() / 2] / factor;
  const bool is_usual = IsUsual(median);
  if (is_usual && !HasGaps(sorted)) return;
  DepthSurvey survey;
  for (const cv::Mat& raw : images) survey.Add(raw);
  const DepthStatistics statistics = survey.Describe();
  if (is_usual && !statistics.inverse_step) return;
  const std::vector<DepthGuess> guesses = IdentifyDepthSensor(statistics, factor);
  if (guesses.empty()) return;
  const DepthGuess& best = guesses.front();
  if (ProbabilityOfFactor(guesses, best.depth_factor) > kSureFactor &&
      ProbabilityOfFactor(guesses, factor) < kImpossibleFactor &&
      best.profile->principle != DepthPrinciple::kUnknown) {
    findings->push_back(WrongFactor("the depth images are those of a " +
                                        std::string(best.profile->name) + " with depth factor " +
                                        Short(best.depth_factor) + ", not " + Short(factor),
                                    best.depth_factor));
    return;
  }
  const auto in_range = [&](double by) {
    return ShareBetween(sorted, by * sensor.min_depth, by * sensor.max_depth);
  };
  if (is_usual) return;
  for (const double other : {1000.0, 5000.0}) {
    if (in_range(factor) > kHardlyAny || in_range(other) < kNearlyAllReadings ||
        ProbabilityOfFactor(guesses, other) < kPossibleFactor) {
      continue;
    }
    findings->push_back(WrongFactor(
        Percent(1.0 - in_range(factor)) + " of the depth readings lie outside of the sensor's " +
            "range of " + Short(sensor.min_depth) + " to " + Short(sensor.max_depth) +
            " m with depth factor " + Short(factor) + ", and hardly any with " + Short(other),
        other));
    return;
  }
  const std::optional<double> noise = NoiseRatio(statistics, sensor);
  if (!noise) return;
  if (auto finding = UnlikelyScale(median, *noise, sensor)) {
    findings->push_back(*std::move(finding));
  }
}

bool DepthCheck::Tests::IsDelayed(const DelayFit& fit) const {
  const double beyond = std::abs(fit.delay) - DepthDelayFinder::kUsual;
  return std::abs(fit.delay) > kLate && beyond > kSigmas * std::max(fit.sigma, kDelaySigma) &&
         fit.correlation > std::max(kEdgesFit, kDelayFitsBetter * fit.usual) &&
         fit.better > kNearlyAlways;
}

void DepthCheck::Tests::AddPlace(std::vector<SensorFinding>* findings) const {
  const std::optional<DepthEdges::Result>& fit = Fit();
  if (!fit) return;
  const double width = size.width;
  const auto is_clear = [&](const EdgeFit& found, double least) {
    const bool is_better =
        found.better > kNearlyAlways || (images.size() > kFewImages && found.sigmas > kFitSigmas);
    return found.correlation > least && is_better &&
           std::max(found.sigma_u, found.sigma_v) < kStable * width;
  };
  const EdgeFit &flipped = fit->flipped, &shifted = fit->shifted;
  const double least_ratio = images.size() > kFewImages ? kManyEdgesFitBetter : kEdgesFitBetter;
  if (is_clear(flipped, kFewEdgesFit) && flipped.correlation > least_ratio * shifted.correlation &&
      std::hypot(flipped.shift_u, flipped.shift_v) < kNearCentre * width) {
    findings->push_back(MirroredDepth(flipped.flip));
    return;
  }
  const std::optional<DelayFit> delayed = delay.Fit();
  const double far = std::hypot(shifted.shift_u, shifted.shift_v);
  if (delayed && IsDelayed(*delayed) &&
      (far < kShifted * width || delayed->correlation > shifted.correlation)) {
    findings->push_back(DelayedDepth(delayed->delay));
    return;
  }
  // What fits as well with a usual delay is explained by it.
  const double as_it_is = delayed ? std::max(fit->correlation, delayed->usual) : fit->correlation;
  const ViewFit& view = fit->view;
  // The best of many delays of eight images fits by chance more than the mean of thirty.
  const double without =
      images.size() > kFewImages ? std::max(fit->correlation, as_it_is / 2.0) : as_it_is;
  if (view.correlation > std::max({kViewFits, kViewFitsBetter * shifted.correlation,
                                   kViewFitsMuchBetter * without}) &&
      view.correlation > flipped.correlation && view.better > kMostlyView &&
      view.spread < kStableView) {
    findings->push_back(OtherView(view.share));
    return;
  }
  const cv::Point2d beside = delay.ShiftBesideDelay({shifted.shift_u, shifted.shift_v});
  const double sigma = std::hypot(shifted.sigma_u, shifted.sigma_v);
  // Eight images of few edges may be of one view, whose outlines agree elsewhere by chance.
  const bool is_far = images.size() > kFewImages && is_clear(shifted, kFewEdgesFit) &&
                      far > kFewEdgesShift * width &&
                      shifted.correlation > kFewEdgesShiftBetter * as_it_is;
  // Depth that is some 20 ms late lies as far off as the camera turns: of more images that looks
  // more certain than it is.
  const bool is_shifted =
      images.size() <= kFewImages && is_clear(shifted, kEdgesFit) && far > kShifted * width &&
      shifted.correlation > std::max(kShiftFitsBetter * as_it_is, as_it_is + kShiftFitsAbove);
  // Edges of slanted ground lie some pixels above or below those of colour, at any delay.
  const bool is_beside = std::hypot(beside.x, beside.y) > kShifted * width ||
                         std::abs(beside.x) > kBesideDelay * width;
  if ((is_shifted || is_far) && far > kSigmas * sigma && is_beside) {
    findings->push_back(ShiftedDepth(shifted, size.width));
  }
}

cv::Mat StoredDepth(const cv::Mat& depth, const RgbdSensor& sensor) {
  HIGHWALL_REQUIRE(depth.type() == CV_32FC1, "StoredDepth: the image must be CV_32FC1");
  cv::Mat stored;
  if (sensor.inverse_depth_offset == 0.0 && sensor.depth_pattern.IsZero()) {
    depth.convertTo(stored, CV_16U, sensor.depth_factor);
    return stored;
  }
  stored.create(depth.size(), CV_16UC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      const double off =
          sensor.inverse_depth_offset + sensor.depth_pattern.At(u, v, depth.cols, depth.rows);
      stored.at<std::uint16_t>(v, u) =
          cv::saturate_cast<std::uint16_t>(sensor.depth_factor * z / (1.0 + z * off));
    }
  }
  return stored;
}

DepthCheck::DepthCheck(const RgbdSensor& sensor)
    : sensor_((sensor.Validate(), sensor)), tests_(std::make_unique<Tests>()) {}

DepthCheck::~DepthCheck() = default;

void DepthCheck::Add(const cv::Mat& raw, const cv::Mat& bgr) {
  HIGHWALL_REQUIRE(raw.type() == CV_16UC1 && bgr.type() == CV_8UC3 && raw.size() == bgr.size(),
                   "DepthCheck: the images must be CV_16UC1 and CV_8UC3, of the same size");
  HIGHWALL_REQUIRE(tests_->images.empty() || raw.size() == tests_->size,
                   "DepthCheck: the images differ in size");
  tests_->size = raw.size();
  tests_->images.push_back(raw);
  tests_->values.Add(raw, bgr);
  const cv::Mat measured = Measured(raw, sensor_);
  tests_->bend.Add(measured);
  tests_->edges.Add(measured, bgr);
  constexpr int kStep = 8;  // [px] between the readings of the sample
  for (int v = 0; v < raw.rows; v += kStep) {
    for (int u = 0; u < raw.cols; u += kStep) {
      if (const std::uint16_t value = raw.at<std::uint16_t>(v, u))
        tests_->readings.push_back(value);
    }
  }
}

void DepthCheck::AddAround(const cv::Mat& raw, const std::vector<cv::Mat>& bgr, double interval,
                           double stated) {
  HIGHWALL_REQUIRE(bgr.size() >= 3 && bgr.size() % 2 == 1 && interval > 0.0,
                   "DepthCheck: an odd number of colour images, at least three, must be given");
  for (const cv::Mat& image : bgr) {
    HIGHWALL_REQUIRE(
        raw.type() == CV_16UC1 && image.type() == CV_8UC3 && raw.size() == image.size(),
        "DepthCheck: the images must be CV_16UC1 and CV_8UC3, of the same size");
  }
  tests_->delay.Add(Measured(raw, sensor_), bgr, interval, stated);
}

std::vector<SensorFinding> DepthCheck::Findings() const {
  const DepthValues& values = tests_->values;
  if (values.IsUniform()) return {ConstantDepth("depth is the same at all pixels")};
  if (values.IsFrozen()) {
    return {ConstantDepth("all depth images are the same, although the colour images differ")};
  }
  if (values.HasSwappedBytes()) return {SwappedBytes()};
  std::vector<SensorFinding> findings;
  const std::optional<SentinelValue> sentinel = values.Sentinel();
  if (sentinel && sentinel->value <= sensor_.max_depth * sensor_.depth_factor) {
    findings.push_back(
        {SensorFault::kDepthSaturated, Trust::kDoubtful,
         Percent(sentinel->share) + " of the depth pixels hold the value " +
             std::to_string(sentinel->value) + ", unlike all around them: it is no reading of " +
             Short(sentinel->value / sensor_.depth_factor) + " m",
         "store 0 where nothing was measured, or set depth_range: {max: ...} below it"});
  }
  if (tests_->bend.inverse() >= kInverseImages &&
      tests_->bend.depth() * 8 <= tests_->bend.inverse()) {
    findings.push_back(InverseDepth());
    return findings;
  }
  tests_->AddScale(sensor_, &findings);
  tests_->AddPlace(&findings);
  return findings;
}

bool DepthCheck::IsUnclear() const {
  constexpr double kBetter = 1.3;  // ratio of correlations
  // Right images with many edges had 0.13 to 0.25, a hand-held recording 100 ms late 0.12: where
  // the camera moves to and fro, what is late is shifted by nothing in the mean.
  constexpr double kClear = 0.13;
  const std::optional<DepthEdges::Result>& fit = tests_->Fit();
  return fit && (fit->correlation < kClear ||
                 std::max({fit->shifted.correlation, fit->flipped.correlation,
                           fit->view.correlation}) > kBetter * fit->correlation);
}

bool DepthCheck::MayMoreImagesShow() const {
  const std::optional<double> median = tests_->MedianDepth(sensor_);
  if (median && !IsUsual(*median)) return true;
  const std::optional<DepthEdges::Result>& fit = tests_->Fit();
  if (!fit) return false;
  const EdgeFit &flipped = fit->flipped, &shifted = fit->shifted;
  const double far = std::hypot(shifted.shift_u, shifted.shift_v);
  return flipped.correlation >
             kHopeful * std::max(kFewEdgesFit, kManyEdgesFitBetter * shifted.correlation) ||
         fit->view.correlation >
             kHopeful * std::max({kViewFits, kViewFitsBetter * shifted.correlation,
                                  kViewFitsMuchBetter * fit->correlation}) ||
         (far > kHopeful * kFewEdgesShift * tests_->size.width &&
          shifted.correlation >
              kHopeful * std::max(kFewEdgesFit, kFewEdgesShiftBetter * fit->correlation));
}

bool DepthCheck::MayBeDelayed() const {
  const std::optional<DelayFit> fit = tests_->delay.Fit();
  return !fit || (std::abs(fit->delay) > kHopeful * kLate &&
                  fit->correlation > kHopeful * std::max(kEdgesFit, kDelayFitsBetter * fit->usual));
}

}  // namespace highwall
