#include "calibration/lens_check.h"

#include <array>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core/types.hpp>

#include "support/synthetic_scene.h"

namespace highwall::lens_check_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::Scene;
using testing::SceneMap;
using testing::UniformInBox;

constexpr unsigned kSeeds = 6;
constexpr KeyFrameId kNoneGiven{};

// Moves a pixel by the factor 1 + k1 r^2 away from the principal point of the ideal sensor.
Eigen::Vector2d Bent(const Eigen::Vector2d& uv, double k1) {
  const PinholeCamera camera = IdealSensor().camera;
  const Eigen::Vector2d centre(camera.cx, camera.cy), focal(camera.fx, camera.fy);
  return centre + (uv - centre) * (1.0 + k1 * (uv - centre).cwiseQuotient(focal).squaredNorm());
}

// Returns the map of keyframes at T_WC, seen by the ideal sensor; they are off by half a centimetre
// and 5 mrad. bias: [1/m] of the measured inverse depth. k1: of a distortion that is not stated.
Map MapFrom(const Scene& scene, const std::vector<Pose>& poses, unsigned seed, double bias,
            double k1 = 0.0) {
  const MeasurementModel model(IdealSensor(), {});
  std::mt19937 rng(seed);
  SceneMap scene_map(scene);
  unsigned view_seed = 100 * seed;
  for (const Pose& T_WC : poses) {
    auto view = Look(scene, IdealSensor(), T_WC,
                     {.px = model.PointSigma(0), .depth = true, .seed = view_seed++});
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (PointFeature& feature : features->points) {
      feature.depth /= 1.0 + bias * feature.depth;
      feature.uv = Bent(feature.uv, k1);
    }
    view.features = features;
    Eigen::Matrix<double, 6, 1> d;
    const Eigen::Vector3d p = UniformInBox(rng, {-5e-3, -5e-3, -5e-3}, {5e-3, 5e-3, 5e-3});
    const Eigen::Vector3d q = UniformInBox(rng, {-5e-3, -5e-3, -5e-3}, {5e-3, 5e-3, 5e-3});
    d << p, q;
    scene_map.Add(view, T_WC.Plus(d));
  }
  return std::move(scene_map.map);
}

// Returns the map of a walk that turns among points on all sides.
Map Walk(unsigned seed, int keyframes = 24, double bias = 0.0, double k1 = 0.0) {
  static const Scene scene = testing::MakeSurroundings();
  std::vector<Pose> poses;
  for (int i = 0; i < keyframes; ++i) {
    const double s = i / (keyframes - 1.0) - 0.5;
    poses.push_back(Pose::FromTangent(
        {0.8 * std::sin(9.0 * s), 0.5 * std::cos(7.0 * s), 0.6 * std::sin(5.0 * s)},
        {0.5 * std::sin(11.0 * s), 0.5 * std::sin(7.0 * s), 0.3 * std::cos(5.0 * s)}));
  }
  return MapFrom(scene, poses, seed, bias, k1);
}

// Returns the map of a vehicle that hardly turns: its images determine the lens poorly.
Map Drive(unsigned seed, double bias = 0.0) {
  constexpr int kKeyframes = 24;
  std::mt19937 rng(seed);
  Scene scene;
  while (scene.points.size() < 150) {
    const Eigen::Vector3d p_W = UniformInBox(rng, {-6, -4, 5}, {6, 4, 12});
    const double reach = testing::Uniform(rng, 3, 9);
    scene.points.push_back({p_W, testing::RandomDescriptor(rng), reach});
  }
  std::vector<Pose> poses;
  for (int i = 0; i < kKeyframes; ++i) {
    const double s = i / (kKeyframes - 1.0) - 0.5;
    poses.push_back(
        Pose::FromTangent({0.02 * std::sin(9.0 * s), 0.01 * std::cos(7.0 * s), 1.0 * s},
                          {0.003 * std::sin(11.0 * s), 0.004 * std::sin(7.0 * s), 0.003 * s}));
  }
  return MapFrom(scene, poses, seed, bias);
}

// The model with the lens multiplied and shifted.
MeasurementModel Model(double fx, double fy, double cx = 0.0) {
  RgbdSensor sensor = IdealSensor();
  sensor.camera.fx *= fx;
  sensor.camera.fy *= fy;
  sensor.camera.cx += cx;
  return {sensor, {}};
}

TEST(EstimateLens, IsWithinItsStandardDeviations) {
  double nees = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Map map = Walk(seed);
    const auto found = EstimateLens(map, Model(1.0, 1.0), map.keyframe_ids());
    ASSERT_TRUE(found);
    const PinholeCamera truth = IdealSensor().camera;
    const Eigen::Vector4d error =
        found->intrinsics - Eigen::Vector4d(truth.fx, truth.fy, truth.cx, truth.cy);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 3.0);
    nees += error.cwiseQuotient(found->sigma).squaredNorm() / (4.0 * kSeeds);
  }
  // Mean of 24 squares, each by a sigma of seven degrees of freedom: 1.4 +- 0.6.
  EXPECT_LT(nees, 4.0);
  EXPECT_GT(nees, 0.2);
}

TEST(LensCheck, SaysNothingOfARightLensOneThatIsOffByTwoPercentAndDepthThatIs) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const double focal : {1.0, 0.98, 1.02}) {
      LensCheck check;
      const auto found = check.Finish(Walk(seed), Model(focal, focal), kFirstSubmap, kNoneGiven);
      EXPECT_FALSE(found) << seed << ": " << Line(*found);
    }
    // 2 % at 3 m
    LensCheck check;
    const auto found =
        check.Finish(Walk(seed, 24, -0.0065), Model(1.0, 1.0), kFirstSubmap, kNoneGiven);
    EXPECT_FALSE(found) << seed << ": " << Line(*found);
  }
}

TEST(LensCheck, FindsFocalLengthsOfAnotherImageSize) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const double factor : {0.5, 0.75, 1.333, 2.0}) {
      LensCheck check;
      const auto found = check.Update(Walk(seed), Model(factor, factor), kFirstSubmap, kNoneGiven);
      ASSERT_TRUE(found) << seed << ", " << factor;
      EXPECT_EQ(found->fault, SensorFault::kLens);
      EXPECT_EQ(found->trust, Trust::kNotTrusted);
      EXPECT_TRUE(found->text.starts_with("the focal lengths are likely 52")) << found->text;
    }
  }
}

TEST(LensCheck, FindsOneWrongFocalLengthAndAPrincipalPoint) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    LensCheck one, centre;
    EXPECT_TRUE(one.Finish(Walk(seed), Model(1.3, 1.0), kFirstSubmap, kNoneGiven)) << seed;
    const auto found = centre.Finish(Walk(seed), Model(1.0, 1.0, 100.0), kFirstSubmap, kNoneGiven);
    ASSERT_TRUE(found) << seed;
    EXPECT_TRUE(found->text.starts_with("the principal point is likely at 3")) << found->text;
  }
}

// The standard deviation of a focal length is 2 to 6 % there, depending on the points.
TEST(LensCheck, FindsFarOffFocalLengthsInAMotionThatHardlyShowsThem) {
  std::array<unsigned, 2> found_with{};
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const bool twice : {false, true}) {
      LensCheck check;
      const double factor = twice ? 2.0 : 0.5;
      if (check.Finish(Drive(seed), Model(factor, factor), kFirstSubmap, kNoneGiven)) {
        ++found_with[twice ? 1 : 0];
      }
    }
    for (const double bias : {0.0, -0.0065, 0.0065}) {
      LensCheck check;
      const auto found = check.Finish(Drive(seed, bias), Model(1.0, 1.0), kFirstSubmap, kNoneGiven);
      EXPECT_FALSE(found) << seed << ", " << bias << ": " << Line(*found);
    }
  }
  EXPECT_GE(found_with[0], kSeeds - 2);
  EXPECT_GE(found_with[1], kSeeds - 1);
}

TEST(LensCheck, FindsAPrincipalPointThatIsOffByAFewPercentWithFewKeyframes) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const double off : {-25.0, 25.0}) {
      LensCheck check;
      const auto found =
          check.Finish(Walk(seed, 14), Model(1.0, 1.0, off), kFirstSubmap, kNoneGiven);
      ASSERT_TRUE(found) << seed << ", " << off;
      EXPECT_EQ(found->trust, Trust::kDoubtful);
      EXPECT_TRUE(found->text.starts_with("the principal point is likely at 3")) << found->text;
    }
    // Calibrations of one camera differ by as much.
    LensCheck check;
    const auto found =
        check.Finish(Walk(seed, 14), Model(1.0, 1.0, 10.0), kFirstSubmap, kNoneGiven);
    EXPECT_FALSE(found) << seed << ": " << Line(*found);
  }
}

TEST(LensCheck, FindsDistortionThatIsNotStated) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const double k1 : {-0.2, 0.2}) {
      LensCheck check;
      const auto found =
          check.Finish(Walk(seed, 24, 0.0, k1), Model(1.0, 1.0), kFirstSubmap, kNoneGiven);
      ASSERT_TRUE(found) << seed << ", " << k1;
      EXPECT_NE(found->text.find(k1 > 0.0 ? "too far from" : "too near to"), std::string::npos)
          << found->text;
    }
    LensCheck check;
    const auto found =
        check.Finish(Walk(seed, 24, 0.0, 0.01), Model(1.0, 1.0), kFirstSubmap, kNoneGiven);
    EXPECT_FALSE(found) << seed << ": " << Line(*found);
  }
}

TEST(LensCheck, WaitsForKeyframesAndTestsTheSameOnlyOnce) {
  const MeasurementModel wrong = Model(2.0, 2.0);
  LensCheck check;
  EXPECT_FALSE(check.Update(Walk(1, 10), wrong, kFirstSubmap, kNoneGiven));
  EXPECT_FALSE(check.Finish(Walk(1, 10), wrong, kFirstSubmap, kNoneGiven));
  EXPECT_TRUE(check.Update(Walk(1, 24), wrong, kFirstSubmap, kNoneGiven));
  EXPECT_FALSE(check.Update(Walk(1, 24), wrong, kFirstSubmap, kNoneGiven));
  EXPECT_FALSE(check.Finish(Walk(1, 24), wrong, kFirstSubmap, kNoneGiven));
}

TEST(LensCheck, BelievesTheStatedLensWhereTheEstimateIsCoarse) {
  const PinholeCamera camera = IdealSensor().camera;
  const Eigen::Vector4d known(camera.fx, camera.fy, camera.cx, camera.cy);
  LensEstimate estimate{.intrinsics = 0.7 * known,
                        .sigma = 0.02 * known,
                        .growth = Eigen::Vector4d::Constant(0.05),
                        .keyframes = 60,
                        .points = 1000};
  const LensSigmas most{.focal = 0.05, .centre = 0.025};
  EXPECT_TRUE(CompareLens(camera, Constrained(estimate, camera, most)));
  estimate.sigma = 0.06 * known;
  estimate.intrinsics = 0.5 * known;  // this is 8 sigma all the same
  EXPECT_FALSE(CompareLens(camera, Constrained(estimate, camera, most)));
}

TEST(LensCheck, BelievesTheStatedLensWherePosesAndPointsAbsorbTheDifference) {
  const PinholeCamera camera = IdealSensor().camera;
  const Eigen::Vector4d known(camera.fx, camera.fy, camera.cx, camera.cy);
  LensEstimate estimate{.intrinsics = known,
                        .sigma = Eigen::Vector4d::Constant(0.0075 * camera.fy)};
  // As in a road of which depth is 2 % too short: cy is 20 sigma off.
  estimate.intrinsics[3] += 0.15 * camera.fy;
  estimate.growth[3] = 5e-4;
  EXPECT_FALSE(CompareLens(camera, estimate));
  estimate.growth[3] = 0.05;
  EXPECT_TRUE(CompareLens(camera, estimate));
}

// A right road of 5 s whose depth was 20 ms late had such an estimate, of 30 standard deviations.
TEST(LensCheck, BelievesACentreInTheMiddleWhereTheEstimateIsVeryFarFromIt) {
  PinholeCamera camera = IdealSensor().camera;
  const double middle = 0.5 * (camera.height - 1.0);
  for (const double stated : {0.0, 0.15}) {
    camera.cy = middle + stated * camera.height;
    for (const double estimated : {-0.15, -0.25}) {
      LensEstimate estimate{
          .intrinsics = {camera.fx, camera.fy, camera.cx, middle + estimated * camera.height},
          .sigma = Eigen::Vector4d::Constant(0.005 * camera.fx),
          .growth = Eigen::Vector4d::Constant(0.02),
          .keyframes = 14};
      EXPECT_EQ(CompareLens(camera, estimate).has_value(), stated > 0.0 || estimated > -0.2)
          << stated << " " << estimated;
    }
  }
}

TEST(LensCheck, BelievesTheStatedLensWhereTheEstimateIsOfNoLens) {
  PinholeCamera camera = IdealSensor().camera;
  LensEstimate estimate{.intrinsics = {camera.fx, camera.fy, camera.cx, camera.cy},
                        .sigma = Eigen::Vector4d::Constant(0.02 * camera.fx),
                        .growth = Eigen::Vector4d::Constant(0.05),
                        .keyframes = 60};
  // One longer by 3 and the other shorter by 8 standard deviations.
  estimate.intrinsics[0] *= 1.06;
  estimate.intrinsics[1] *= 0.84;
  EXPECT_FALSE(CompareLens(camera, estimate));
  // No image is stretched as much; one that is, by half, is believed.
  LensEstimate stretched = estimate;
  stretched.intrinsics[0] = 0.16 * camera.fx;
  stretched.intrinsics[1] = camera.fy;
  EXPECT_FALSE(CompareLens(camera, stretched));
  stretched.intrinsics[0] = 0.5 * camera.fx;
  EXPECT_TRUE(CompareLens(camera, stretched));
  // Nearer to square pixels than what is stated.
  camera.fx = 1.25 * estimate.intrinsics[0];
  camera.fy = 0.75 * estimate.intrinsics[1];
  EXPECT_TRUE(CompareLens(camera, estimate));
  // Both shorter.
  camera.fx = 1.25 * estimate.intrinsics[0];
  camera.fy = 1.25 * estimate.intrinsics[1];
  EXPECT_TRUE(CompareLens(camera, estimate));
}

// As with the coefficients of a fisheye lens, taken for radial and tangential ones: the focal
// lengths are those of no lens, and corners are 6 % too far inside.
TEST(CompareLens, FindsAClearDistortionOfAnEstimateThatIsOfNoLens) {
  const PinholeCamera camera = IdealSensor().camera;
  LensEstimate estimate{.sigma = Eigen::Vector4d::Constant(0.015 * camera.fx), .keyframes = 18};
  estimate.intrinsics << 1.08 * camera.fx, 0.93 * camera.fy, camera.cx, camera.cy;
  estimate.growth << 0.02, 0.008, 0.0, 0.0;
  EXPECT_FALSE(CompareLens(camera, estimate));
  estimate.distortion = {.k1 = -0.1, .sigma = 0.004, .growth = 0.4};
  const auto finding = CompareLens(camera, estimate);
  ASSERT_TRUE(finding);
  EXPECT_NE(finding->text.find("distortion"), std::string::npos) << finding->text;
  estimate.distortion.growth = 0.01;
  EXPECT_FALSE(CompareLens(camera, estimate));
}

TEST(CheckUnusualCentre, DoubtsACentreFarFromTheMiddleUnlessTheImagesConfirmIt) {
  PinholeCamera camera = IdealSensor().camera;
  EXPECT_FALSE(CheckUnusualCentre(camera, std::nullopt));
  const double middle = 0.5 * (camera.height - 1.0);
  camera.cy = middle + 0.14 * camera.height;
  EXPECT_FALSE(CheckUnusualCentre(camera, std::nullopt));
  camera.cy = middle + 0.2 * camera.height;
  const auto finding = CheckUnusualCentre(camera, std::nullopt);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->fault, SensorFault::kLens);
  EXPECT_EQ(finding->trust, Trust::kDoubtful);
  EXPECT_NE(finding->text.find("cy is 20 %"), std::string::npos) << finding->text;
  LensEstimate estimate{.intrinsics = {camera.fx, camera.fy, camera.cx, camera.cy}};
  estimate.sigma.setConstant(0.05 * camera.height);
  EXPECT_FALSE(CheckUnusualCentre(camera, estimate));
  // Too uncertain, and nearer to the middle.
  estimate.sigma.setConstant(0.1 * camera.height);
  EXPECT_TRUE(CheckUnusualCentre(camera, estimate));
  estimate.sigma.setConstant(0.01 * camera.height);
  estimate.intrinsics[3] = middle + 0.08 * camera.height;
  EXPECT_TRUE(CheckUnusualCentre(camera, estimate));
  // Of an image whose size is unknown.
  camera.width = camera.height = 0;
  EXPECT_FALSE(CheckUnusualCentre(camera, std::nullopt));
}

TEST(CheckFarCentre, NeedsLessEvidenceThatACentreFarFromTheMiddleIsNearIt) {
  PinholeCamera camera = IdealSensor().camera;
  const double middle = 0.5 * (camera.width - 1.0);
  LensEstimate estimate{.sigma = Eigen::Vector4d::Constant(0.04 * camera.fx), .keyframes = 12};
  estimate.growth[2] = 0.002;
  estimate.intrinsics << camera.fx, camera.fy, middle, camera.cy;
  camera.cx = middle + 0.16 * camera.width;
  EXPECT_FALSE(CompareLens(camera, estimate));
  EXPECT_TRUE(CheckFarCentre(camera, estimate));
  // Neither a centre that is stated in the middle, nor an estimate beyond the stated one.
  camera.cx = middle;
  estimate.intrinsics[2] = middle + 0.16 * camera.width;
  EXPECT_FALSE(CheckFarCentre(camera, estimate));
  camera.cx = middle + 0.16 * camera.width;
  estimate.intrinsics[2] = middle + 0.32 * camera.width;
  EXPECT_FALSE(CheckFarCentre(camera, estimate));
}

TEST(CheckFarCentre, FindsACentreEightPercentOffAlsoByAnEstimateBeyondTheMiddle) {
  PinholeCamera camera = IdealSensor().camera;
  const double middle = 0.5 * (camera.width - 1.0);
  LensEstimate estimate{.sigma = Eigen::Vector4d::Constant(0.04 * camera.fx), .keyframes = 12};
  estimate.growth[2] = 0.002;
  camera.cx = middle + 0.08 * camera.width;
  estimate.intrinsics << camera.fx, camera.fy, middle - 0.1 * camera.width, camera.cy;
  EXPECT_TRUE(CheckFarCentre(camera, estimate));
  camera.cx = middle + 0.06 * camera.width;
  EXPECT_FALSE(CheckFarCentre(camera, estimate));
}

// Estimates as a right lens has them: their errors have the stated standard deviations, which are
// known by eight groups, and absorb a part of what is off by up to 2 % in the focal lengths. One in
// ten cameras has a principal point far from the middle. At a rate of one in a thousand, eight and
// more alarms in 3000 draws have a probability of 1 %.
TEST(CompareLens, RaisesFalseAlarmsAtMostOnceInAThousandDraws) {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::chi_squared_distribution<double> groups(7.0);
  int alarms = 0;
  for (int i = 0; i < 3000; ++i) {
    PinholeCamera camera = IdealSensor().camera;
    if (uniform(rng) < 0.1) camera.cx += (0.3 * uniform(rng) - 0.15) * camera.width;
    LensEstimate estimate{.keyframes = uniform(rng) < 0.5 ? 12 : 40, .points = 1000};
    const double views = 500.0 + 5000.0 * uniform(rng);
    const Eigen::Vector4d truth(camera.fx, camera.fy, camera.cx, camera.cy);
    for (int k = 0; k < 4; ++k) {
      const double sigma = 0.05 * uniform(rng) * camera.fx, error = normal(rng);
      const double off = k < 2 ? 0.02 * camera.fx * (2.0 * uniform(rng) - 1.0) : 0.0;
      estimate.intrinsics[k] = truth[k] + sigma * error + off;
      estimate.sigma[k] = sigma * std::sqrt(groups(rng) / 7.0);
      estimate.growth[k] = (error * error + std::pow(off / sigma, 2)) / (2.0 * views);
    }
    const double sigma = 0.05 * uniform(rng), error = normal(rng);
    estimate.distortion = {sigma * error, sigma * std::sqrt(groups(rng) / 7.0),
                           error * error / (2.0 * views)};
    alarms += CompareLens(camera, estimate) || CheckFarCentre(camera, estimate) ? 1 : 0;
  }
  EXPECT_LE(alarms, 7);
}

TEST(LensCheck, NeedsClearEvidenceOfASmallDeviation) {
  const PinholeCamera camera = IdealSensor().camera;
  LensEstimate estimate{.sigma = Eigen::Vector4d::Constant(0.002 * camera.fx), .keyframes = 12};
  estimate.intrinsics << camera.fx, camera.fy, camera.cx + 0.05 * camera.fx, camera.cy;
  // As with noisy depth on a road, of which the principal point was 16 % off.
  estimate.growth[2] = 0.007;
  EXPECT_FALSE(CompareLens(camera, estimate));
  estimate.growth[2] = 0.02;
  EXPECT_TRUE(CompareLens(camera, estimate));
}

TEST(LensCheck, FindsFocalLengthsFourPercentOffThatTheImagesContradictVeryClearly) {
  const PinholeCamera camera = IdealSensor().camera;
  LensEstimate estimate{.sigma = Eigen::Vector4d::Constant(0.003 * camera.fx), .keyframes = 15};
  estimate.intrinsics << 0.955 * camera.fx, 0.96 * camera.fy, camera.cx, camera.cy;
  estimate.growth << 0.05, 0.02, 0.0, 0.0;
  EXPECT_TRUE(CompareLens(camera, estimate));
  estimate.growth[0] = 0.025;
  EXPECT_FALSE(CompareLens(camera, estimate));
  // As with a lens that is 2 % off.
  estimate.intrinsics << 1.02 * camera.fx, 1.035 * camera.fy, camera.cx, camera.cy;
  estimate.growth << 0.05, 0.05, 0.0, 0.0;
  EXPECT_FALSE(CompareLens(camera, estimate));
}

TEST(CheckExchangedCentre, FindsACentreThatFitsTheOtherWayRound) {
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(1280, 720)}) {
    PinholeCamera camera = IdealSensor().camera;
    camera.width = size.width;
    camera.height = size.height;
    camera.cx = 0.5 * size.height + 11.0;
    camera.cy = 0.5 * size.width - 7.0;
    const auto finding = CheckExchangedCentre(camera);
    ASSERT_TRUE(finding) << size.width;
    EXPECT_EQ(finding->fault, SensorFault::kLens);
    EXPECT_NE(finding->text.find("exchanged"), std::string::npos) << finding->text;
  }
}

TEST(CheckExchangedCentre, BelievesACentreThatIsOffInOneDirectionOrOfASquareImage) {
  PinholeCamera camera = IdealSensor().camera;
  camera.width = 640;
  camera.height = 480;
  for (const Eigen::Vector2d& centre :
       {Eigen::Vector2d(319.5, 239.5), Eigen::Vector2d(200.0, 239.5), Eigen::Vector2d(319.5, 380.0),
        Eigen::Vector2d(240.0, 100.0)}) {
    camera.cx = centre.x();
    camera.cy = centre.y();
    EXPECT_FALSE(CheckExchangedCentre(camera)) << centre.transpose();
  }
  camera.width = 480;
  camera.cx = 200.0;
  camera.cy = 180.0;
  EXPECT_FALSE(CheckExchangedCentre(camera));
}

}  // namespace
}  // namespace highwall::lens_check_test
