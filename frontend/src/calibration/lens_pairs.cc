#include <highwall/frontend/calibration/lens_pairs.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>

#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/frontend/map/measurement_model.h>

#include "calibration/depth_motion.h"
#include "calibration/lens_check.h"
#include "calibration/lens_estimate.h"
#include "features/frame_builder.h"

namespace highwall {
namespace {

constexpr std::size_t kPairs = 8, kLeastPairs = 6;
constexpr double kApart = 0.3;            // [s] between the images of a pair: some degrees, by hand
constexpr std::size_t kLeastApart = 2;    // frames
constexpr std::size_t kLeastFrames = 24;  // of a recording: in fewer, pairs share too much
constexpr double kEpipolarDistance = 1.5;  // [px] at a width of 640
constexpr double kConfidence = 0.999;
constexpr std::size_t kLeastMatches = 40;  // with depth in both images
// Standard deviations, relative to the focal length, beyond which an estimate is left out: a camera
// on a vehicle hardly rolls or pitches, so that little errors of depth shift the principal point.
constexpr double kFocalSigma = 0.025, kCentreSigma = 0.01;
// Relative growth of the squared residuals with a principal point that is far from the middle; with
// the right one it was up to 0.0035.
constexpr double kGrowthOfCentre = 0.015;

struct PairedPoints {
  std::shared_ptr<const FrameFeatures> first, second;
  std::vector<FeatureMatch> matches;
};

const PointFeature& FirstOf(const PairedPoints& pair, const FeatureMatch& match) {
  return pair.first->points[static_cast<std::size_t>(match.query)];
}
const PointFeature& SecondOf(const PairedPoints& pair, const FeatureMatch& match) {
  return pair.second->points[static_cast<std::size_t>(match.train)];
}

// Removes the matches that contradict the epipolar geometry of the others.
void KeepEpipolar(double max_distance, PairedPoints* pair) {
  std::vector<cv::Point2d> first, second;
  for (const FeatureMatch& match : pair->matches) {
    const Eigen::Vector2d a = FirstOf(*pair, match).uv, b = SecondOf(*pair, match).uv;
    first.emplace_back(a.x(), a.y());
    second.emplace_back(b.x(), b.y());
  }
  std::vector<std::uint8_t> inliers;
  cv::findFundamentalMat(first, second, cv::FM_RANSAC, max_distance, kConfidence, inliers);
  if (inliers.size() != first.size()) return pair->matches.clear();
  std::size_t next = 0;
  std::erase_if(pair->matches, [&](const FeatureMatch&) { return inliers[next++] == 0; });
}

std::optional<PairedPoints> MatchPair(const Dataset& dataset, std::size_t first, std::size_t second,
                                      FrameBuilder* builder) {
  const std::optional<RgbdImage> a = dataset.Load(first), b = dataset.Load(second);
  const cv::Size size(builder->camera().width, builder->camera().height);
  if (!a || !b || a->bgr.size() != size || b->bgr.size() != size) return std::nullopt;
  PairedPoints pair{builder->Build(*a), builder->Build(*b), {}};
  pair.matches = MatchDescriptors(pair.first->point_descriptors, pair.second->point_descriptors);
  std::erase_if(pair.matches, [&](const FeatureMatch& match) {
    return FirstOf(pair, match).depth <= 0.0 || SecondOf(pair, match).depth <= 0.0;
  });
  if (pair.matches.size() < kLeastMatches) return std::nullopt;
  KeepEpipolar(kEpipolarDistance * size.width / 640.0, &pair);
  if (pair.matches.size() < kLeastMatches) return std::nullopt;
  return pair;
}

// Adds a pair as a world of its own, that of its first image.
void AddPair(const PairedPoints& pair, const MeasurementModel& model, LensViews* views) {
  const auto count = static_cast<Eigen::Index>(pair.matches.size());
  Eigen::Matrix3Xd first(3, count), second(3, count);
  const std::size_t image = views->T_CW.size();
  for (Eigen::Index i = 0; i < count; ++i) {
    const FeatureMatch& match = pair.matches[static_cast<std::size_t>(i)];
    const PointFeature &a = FirstOf(pair, match), &b = SecondOf(pair, match);
    first.col(i) = model.camera().Unproject(a.uv, a.depth);
    second.col(i) = model.camera().Unproject(b.uv, b.depth);
    views->points.push_back({first.col(i), {{image, model.Rows(a)}, {image + 1, model.Rows(b)}}});
  }
  // A wrong lens shears both sets of points alike: the motion between them is nearly right.
  views->held.push_back(image);
  views->T_CW.emplace_back();
  views->T_CW.push_back(Pose::FromMatrix(Eigen::umeyama(first, second, false)));
}

// Returns what eight pairs of images contradict. estimate: output, if they give one.
std::optional<SensorFinding> TestPairs(const Dataset& dataset, const RgbdSensor& sensor,
                                       std::size_t begin, std::size_t end,
                                       std::optional<LensEstimate>* estimate) {
  end = std::min(end, dataset.size());
  if (end < begin + kLeastFrames) return std::nullopt;
  const std::size_t frames = end - begin;
  const double seconds = ToSeconds(dataset.stamp(end - 1) - dataset.stamp(begin));
  const double rate = seconds > 0.0 ? static_cast<double>(frames - 1) / seconds : 0.0;
  const std::size_t apart =
      std::clamp(static_cast<std::size_t>(std::max(0.0, rate * kApart)), kLeastApart, frames / 3);
  FrameBuilderOptions options;
  options.use_lines = false;
  FrameBuilder builder(sensor, options, nullptr, nullptr, false);
  const MeasurementModel model(sensor, {});
  LensViews views;
  DepthMotion motion(model);
  for (std::size_t i = 0; i < kPairs; ++i) {
    const std::size_t first = begin + i * (frames - 1 - apart) / (kPairs - 1);
    if (const auto pair = MatchPair(dataset, first, first + apart, &builder)) {
      AddPair(*pair, model, &views);
      motion.Add(*pair->first, *pair->second, pair->matches);
    }
  }
  if (views.held.size() < kLeastPairs) return std::nullopt;
  // Wrong depth contradicts any lens.
  if (auto misread = motion.Misread()) return misread;
  *estimate = EstimateLens(std::move(views), model);
  if (!*estimate) return std::nullopt;
  const LensEstimate constrained =
      Constrained(**estimate, model.camera(), {kFocalSigma, kCentreSigma});
  if (auto finding = CompareLens(model.camera(), constrained)) return finding;
  return CheckFarCentre(model.camera(), **estimate, kGrowthOfCentre);
}

}  // namespace

std::optional<SensorFinding> CheckPairs(const Dataset& dataset, const RgbdSensor& sensor,
                                        std::size_t begin, std::size_t end) {
  std::optional<LensEstimate> estimate;
  if (auto finding = TestPairs(dataset, sensor, begin, end, &estimate)) return finding;
  if (auto exchanged = CheckExchangedCentre(sensor.camera)) return exchanged;
  return CheckUnusualCentre(sensor.camera, estimate);
}

}  // namespace highwall
