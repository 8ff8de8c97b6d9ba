#include "calibration/lens_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr std::size_t kMostTested = 60;  // keyframes, the newest ones
constexpr double kSignificant = 6.0;     // standard deviations
// Least relative growth of the squared residuals with the stated value. A deviation that poses and
// points absorb is no evidence: errors of depth or of stamps shift values that the motion hardly
// determines by many standard deviations, because all keyframes share them. With the right lens the
// growth was below 0.003, with one that is wrong by a factor of two above 0.007.
constexpr double kLeastGrowth = 0.005;
constexpr int kManyKeyframes = 20;  // with fewer, twice the tolerance: they may all look one way
// Twice as much for the principal point: a camera that hardly rolls or pitches, as on a vehicle,
// sees a shift of it as a constant rotation.
constexpr double kOfCentre = 2.0;
constexpr LensSigmas kMostSigmas{.focal = 0.05, .centre = 0.025};
constexpr double kFarOffLens = 0.1;  // relative: poses are not to be trusted

std::string WithSigma(double value, double sigma) {
  return FixedText(value, 0) + " +- " + FixedText(std::max(1.0, sigma), 0);
}

// Returns "a" or "a and b", both with their standard deviations.
std::string Pair(const Eigen::Vector2d& values, const Eigen::Vector2d& sigmas) {
  return WithSigma(values.x(), sigmas.x()) + " and " + WithSigma(values.y(), sigmas.y());
}

std::vector<KeyFrameId> NewestMadeIn(const Map& map, SubmapId submap, KeyFrameId given,
                                     std::size_t* made) {
  std::vector<KeyFrameId> ids = map.KeyFramesOf(submap);
  std::erase_if(ids, [given](KeyFrameId id) { return id <= given; });
  *made = ids.size();
  if (ids.size() > kMostTested) ids.erase(ids.begin(), ids.end() - kMostTested);
  return ids;
}

std::optional<SensorFinding> TestLens(const Map& map, const MeasurementModel& model,
                                      const std::vector<KeyFrameId>& keyframes) {
  const std::optional<LensEstimate> estimate = EstimateLens(map, model, keyframes);
  if (!estimate) return std::nullopt;
  return CompareLens(model.camera(), Constrained(*estimate, model.camera(), kMostSigmas),
                     (estimate->keyframes < kManyKeyframes ? 2.0 : 1.0) * kLensTolerance);
}

}  // namespace

LensEstimate Constrained(LensEstimate estimate, const PinholeCamera& camera,
                         const LensSigmas& most) {
  const Eigen::Vector4d known(camera.fx, camera.fy, camera.cx, camera.cy);
  for (int i = 0; i < 4; ++i) {
    const double focal = std::max(known[i % 2], estimate.intrinsics[i % 2]);
    if (estimate.sigma[i] > (i < 2 ? most.focal : most.centre) * focal) {
      estimate.intrinsics[i] = known[i];
    }
  }
  return estimate;
}

std::optional<SensorFinding> CompareLens(const PinholeCamera& camera, const LensEstimate& estimate,
                                         double tolerance) {
  const Eigen::Vector4d known(camera.fx, camera.fy, camera.cx, camera.cy);
  const Eigen::Vector4d off = (estimate.intrinsics - known).cwiseAbs();
  double worst = 0.0;  // relative deviation of those that count
  const auto deviates = [&](int i) {
    // The larger focal length: a wrong one is too small or too large.
    const double focal = std::max(known[i % 2], estimate.intrinsics[i % 2]);
    const double least = (i < 2 ? 1.0 : kOfCentre) * tolerance * focal;
    if (off[i] <= std::max(least, kSignificant * estimate.sigma[i])) return false;
    if (estimate.growth[i] <= kLeastGrowth) return false;
    worst = std::max(worst, off[i] / focal);
    return true;
  };
  const std::array<bool, 4> wrong{deviates(0), deviates(1), deviates(2), deviates(3)};
  const bool focal = wrong[0] || wrong[1];
  if (!focal && !wrong[2] && !wrong[3]) return std::nullopt;
  std::string text;
  if (focal) {
    text = "the focal lengths are likely " +
           Pair(estimate.intrinsics.head<2>(), estimate.sigma.head<2>()) + " px, not " +
           RoundedText(camera.fx, 4) + " and " + RoundedText(camera.fy, 4);
  } else {
    text = "the principal point is likely at " +
           Pair(estimate.intrinsics.tail<2>(), estimate.sigma.tail<2>()) + " px, not " +
           RoundedText(camera.cx, 4) + " and " + RoundedText(camera.cy, 4);
  }
  return SensorFinding{SensorFault::kLens,
                       worst > kFarOffLens ? Trust::kNotTrusted : Trust::kDoubtful, std::move(text),
                       "set fx, fy, cx and cy to those of the colour camera at this image size; "
                       "highwall calibrate refines them"};
}

std::optional<SensorFinding> CheckExchangedCentre(const PinholeCamera& camera) {
  constexpr double kNear = 0.08;  // of the image's side: a 4:3 image exchanges 0.5 and 0.37 or 0.67
  const Eigen::Array2d size(camera.width, camera.height), stated(camera.cx, camera.cy);
  const Eigen::Array2d off = (stated / size - 0.5).abs();
  const Eigen::Array2d exchanged_off = (stated.reverse() / size - 0.5).abs();
  if (off.minCoeff() <= kNear || exchanged_off.maxCoeff() >= kNear) return std::nullopt;
  return SensorFinding{
      SensorFault::kLens, Trust::kDoubtful,
      "cx and cy are likely exchanged: (" + RoundedText(camera.cx, 4) + ", " +
          RoundedText(camera.cy, 4) +
          ") px is far from the middle of the image, the other way round it is near",
      "exchange cx and cy in the calibration"};
}

std::optional<SensorFinding> LensCheck::Update(const Map& map, const MeasurementModel& model,
                                               SubmapId submap, KeyFrameId given) {
  std::size_t made = 0;
  const std::vector<KeyFrameId> ids = NewestMadeIn(map, submap, given, &made);
  if (made < next_) return std::nullopt;
  next_ = 2 * made;
  tested_ = made;
  return TestLens(map, model, ids);
}

std::optional<SensorFinding> LensCheck::Finish(const Map& map, const MeasurementModel& model,
                                               SubmapId submap, KeyFrameId given) {
  std::size_t made = 0;
  const std::vector<KeyFrameId> ids = NewestMadeIn(map, submap, given, &made);
  if (made == tested_) return std::nullopt;
  tested_ = made;
  return TestLens(map, model, ids);
}

}  // namespace highwall
