#include "calibration/lens_check.h"

#include <algorithm>
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
// growth was below 0.007 (principal point) and 0.0045 (others), with one that is wrong by a factor
// of two mostly above 0.007.
constexpr double kLeastGrowth = 0.005, kClearGrowth = 0.015;
// Deviations that count, of focal lengths and principal point relative to the focal length: from
// the clear growth on, and with less. Calibrations of one camera differ by 2 %, and errors of its
// depth shift the estimate by as much. A camera that hardly rolls or pitches, as on a vehicle, sees
// a shift of the principal point as a constant rotation.
constexpr double kFocalTolerance = 0.05, kCentreTolerance = 0.03;
// The map follows a wrong lens, so that the estimate is off by half of it: with focal lengths that
// are 10 % long it was 4.6 % short at a growth of 5 %, with 2 % up to 3.3 % at 1.8 %.
constexpr double kVeryClearGrowth = 0.03, kVeryClearFocalTolerance = 0.04;
constexpr double kUnclearFocalTolerance = 0.05, kUnclearCentreTolerance = 0.1;
constexpr int kManyKeyframes = 20;  // with fewer, twice as much: they may all look one way
// The same of distortion, relative to the distance of the corners from the principal point.
constexpr double kDistortionTolerance = 0.02;
// A principal point this far from the middle of the image, of its side, is rare (cropped images
// have it): then less evidence suffices if the middle explains the images better.
constexpr double kFarCentre = 0.07, kSignificantCentre = 2.5;
constexpr LensSigmas kMostSigmas{.focal = 0.05, .centre = 0.025};
// That of another model was 0.4; errors of depth and a drive straight ahead leave little.
constexpr double kGrowthOfNoLens = 0.05;
constexpr double kFarOffLens = 0.1;  // relative: poses are not to be trusted

std::string WithSigma(double value, double sigma) {
  return FixedText(value, 0) + " +- " + FixedText(std::max(1.0, sigma), 0);
}

// Returns "a" or "a and b", both with their standard deviations.
std::string Pair(const Eigen::Vector2d& values, const Eigen::Vector2d& sigmas) {
  return WithSigma(values.x(), sigmas.x()) + " and " + WithSigma(values.y(), sigmas.y());
}

constexpr const char* kLensRemedy =
    "set fx, fy, cx and cy to those of the colour camera at this image size; highwall calibrate "
    "refines them";

enum class LensPart { kFocalLengths, kCentre, kDistortion };

// A value of the lens that deviates.
struct Deviation {
  LensPart part;
  double relative = 0.0;  // to the focal length; of distortion, to the radius at the corners
  double growth = 0.0;
};

// Squared distance of the corners from the principal point, in focal lengths.
double CornerSquared(const PinholeCamera& camera) {
  const double x = std::max(camera.cx, camera.width - 1.0 - camera.cx) / camera.fx;
  const double y = std::max(camera.cy, camera.height - 1.0 - camera.cy) / camera.fy;
  return x * x + y * y;
}

// A principal point that is stated in the middle of the image is hardly ever far from it: an
// estimate that says so is of images whose errors of depth look like a rotation.
bool IsUnlikelyCentre(const PinholeCamera& camera, const LensEstimate& estimate, int axis) {
  constexpr double kVeryFarCentre = 0.2;  // of the image's side
  const double side = axis == 0 ? camera.width : camera.height, middle = 0.5 * (side - 1.0);
  const double stated = axis == 0 ? camera.cx : camera.cy,
               estimated = estimate.intrinsics[2 + axis];
  return std::abs(stated - middle) < kFarCentre * side &&
         std::abs(estimated - middle) > kVeryFarCentre * side;
}

std::vector<Deviation> DeviationsOf(const PinholeCamera& camera, const LensEstimate& estimate) {
  std::vector<Deviation> all;
  const auto add = [&](LensPart part, double off, double sigma, double growth, double tolerance) {
    if (std::abs(off) > std::max(tolerance, kSignificant * sigma) && growth > kLeastGrowth) {
      all.push_back({part, std::abs(off), growth});
    }
  };
  const double few = estimate.keyframes < kManyKeyframes ? 2.0 : 1.0;
  const Eigen::Vector4d known(camera.fx, camera.fy, camera.cx, camera.cy);
  for (int i = 0; i < 4; ++i) {
    if (i >= 2 && IsUnlikelyCentre(camera, estimate, i - 2)) continue;
    // The larger focal length: a wrong one is too small or too large.
    const double focal = std::max(known[i % 2], estimate.intrinsics[i % 2]);
    const bool is_clear = estimate.growth[i] > kClearGrowth;
    const double of_focal = estimate.growth[i] > kVeryClearGrowth ? kVeryClearFocalTolerance
                            : is_clear                            ? kFocalTolerance
                                                                  : few * kUnclearFocalTolerance;
    const double of_centre = is_clear ? kCentreTolerance : few * kUnclearCentreTolerance;
    const double tolerance = i < 2 ? of_focal : of_centre;
    add(i < 2 ? LensPart::kFocalLengths : LensPart::kCentre,
        (estimate.intrinsics[i] - known[i]) / focal, estimate.sigma[i] / focal, estimate.growth[i],
        tolerance);
  }
  const LensEstimate::Distortion& distortion = estimate.distortion;
  const double corner = CornerSquared(camera);
  add(LensPart::kDistortion, corner * distortion.k1, corner * distortion.sigma, distortion.growth,
      kDistortionTolerance);
  return all;
}

// Pixels are square, but for images that were stretched: a wrong calibration has focal lengths that
// are both too long or too short, or whose ratio is wrong. An estimate of which one is longer and
// the other shorter, and whose ratio is farther from 1, is that of images that contradict each
// other. One whose ratio is far beyond that of stretched images is that of a motion which hardly
// shows one of them, such as a drive straight ahead.
bool IsOfNoLens(const PinholeCamera& camera, const LensEstimate& estimate) {
  constexpr double kSigmas = 2.0;         // each of both
  constexpr double kMostStretched = 2.5;  // every other row alone: 2
  const Eigen::Array2d stated(camera.fx, camera.fy), found = estimate.intrinsics.head<2>();
  const Eigen::Array2d off = (found - stated) / estimate.sigma.head<2>().array();
  const double ratio = std::abs(std::log(found[0] / found[1]));
  if (ratio <= std::abs(std::log(stated[0] / stated[1]))) return false;
  return ratio > std::log(kMostStretched) || (off.prod() < 0.0 && off.abs().minCoeff() > kSigmas);
}

std::string TextOf(LensPart part, const PinholeCamera& camera, const LensEstimate& estimate) {
  const auto stated = [](double a, double b) {
    return " px, not " + RoundedText(a, 4) + " and " + RoundedText(b, 4);
  };
  if (part == LensPart::kFocalLengths) {
    return "the focal lengths are likely " +
           Pair(estimate.intrinsics.head<2>(), estimate.sigma.head<2>()) +
           stated(camera.fx, camera.fy);
  }
  if (part == LensPart::kCentre) {
    return "the principal point is likely at " +
           Pair(estimate.intrinsics.tail<2>(), estimate.sigma.tail<2>()) +
           stated(camera.cx, camera.cy);
  }
  const double percent = 100.0 * CornerSquared(camera) * estimate.distortion.k1;
  return "by the stated distortion, corners of the image are " + FixedText(std::abs(percent), 0) +
         " % too " + (percent > 0.0 ? "far from" : "near to") + " its principal point";
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
  if (auto finding =
          CompareLens(model.camera(), Constrained(*estimate, model.camera(), kMostSigmas))) {
    return finding;
  }
  return CheckFarCentre(model.camera(), *estimate);
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

std::optional<SensorFinding> CompareLens(const PinholeCamera& camera,
                                         const LensEstimate& estimate) {
  std::vector<Deviation> deviations = DeviationsOf(camera, estimate);
  // Coefficients of another model shift the focal lengths as no lens does, and show by themselves.
  if (IsOfNoLens(camera, estimate)) {
    std::erase_if(deviations, [](const Deviation& deviation) {
      return deviation.part != LensPart::kDistortion || deviation.growth < kGrowthOfNoLens;
    });
  }
  if (deviations.empty()) return std::nullopt;
  const Deviation& clearest = *std::ranges::max_element(deviations, {}, &Deviation::growth);
  const double worst = std::ranges::max_element(deviations, {}, &Deviation::relative)->relative;
  return SensorFinding{SensorFault::kLens,
                       worst > kFarOffLens ? Trust::kNotTrusted : Trust::kDoubtful,
                       TextOf(clearest.part, camera, estimate),
                       clearest.part == LensPart::kDistortion
                           ? "state the model and the coefficients of the colour camera's "
                             "distortion, or none if the images are undistorted"
                           : kLensRemedy};
}

std::optional<SensorFinding> CheckFarCentre(const PinholeCamera& camera,
                                            const LensEstimate& estimate, double least_growth) {
  const auto is_doubtful = [&](int i) {
    const double side = i == 0 ? camera.width : camera.height, middle = 0.5 * (side - 1.0);
    const double stated = i == 0 ? camera.cx : camera.cy, estimated = estimate.intrinsics[2 + i];
    return std::abs(stated - middle) > kFarCentre * side &&
           std::abs(estimated - middle) < std::abs(estimated - stated) &&
           std::abs(estimated - stated) > kSignificantCentre * estimate.sigma[2 + i] &&
           estimate.growth[2 + i] > least_growth;
  };
  if (!is_doubtful(0) && !is_doubtful(1)) return std::nullopt;
  return SensorFinding{SensorFault::kLens, Trust::kDoubtful,
                       TextOf(LensPart::kCentre, camera, estimate), kLensRemedy};
}

std::optional<SensorFinding> CheckUnusualCentre(const PinholeCamera& camera,
                                                const std::optional<LensEstimate>& estimate) {
  // Of the image's side. Lenses have up to 0.05, rectified stereo images up to 0.1.
  constexpr double kUnusual = 0.15;
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? camera.width : camera.height, middle = 0.5 * (side - 1.0);
    const double stated = i == 0 ? camera.cx : camera.cy, off = std::abs(stated - middle) / side;
    if (side < 1.0 || off < kUnusual) continue;  // no size is known
    if (estimate) {
      const double estimated = estimate->intrinsics[2 + i];
      const bool is_confirmed =
          std::abs(estimated - stated) < std::abs(estimated - middle) &&
          std::abs(estimated - middle) > kSignificantCentre * estimate->sigma[2 + i];
      if (is_confirmed) continue;
    }
    return SensorFinding{SensorFault::kLens, Trust::kDoubtful,
                         std::string(i == 0 ? "cx is " : "cy is ") + FixedText(100.0 * off, 0) +
                             " % of the image's " + (i == 0 ? "width" : "height") +
                             " from its middle, which only cropped images have, and the images do "
                             "not confirm it",
                         kLensRemedy};
  }
  return std::nullopt;
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
