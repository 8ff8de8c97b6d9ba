#include <highwall/frontend/input/depth_identification.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/depth_survey.h>

namespace highwall::depth_identification_test {
namespace {

// Maps the depth of a surface [m] to the stored value; 0 where nothing is measured.
using Model = std::function<double(double z, std::mt19937& rng)>;

double Normal(std::mt19937& rng) {
  return std::normal_distribution<double>()(rng);
}

// Returns a model of disparities of focal x baseline [px m] in steps of `step` px, rounded to
// `unit` [1/m], then multiplied.
Model Triangulating(double scale, double step, double sigma, double unit, double times,
                    double most = 1e9) {
  return [=](double z, std::mt19937& rng) {
    const double steps = std::round((scale / z + sigma * Normal(rng)) / step);
    if (steps <= 0.0 || steps * step > most) return 0.0;
    return times * std::round(unit * scale / (steps * step));
  };
}

Model TimeOfFlight(const DepthNoise& noise, double unit) {
  return [=](double z, std::mt19937& rng) {
    return std::round(unit * (z + 0.5 * noise.Sigma(z) * Normal(rng)));
  };
}

// Returns the statistics of several images of slanted walls at several depths.
DepthStatistics Survey(const Model& model, const cv::Size& size = {320, 240}, double holes = 0.1) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  DepthSurvey survey;
  for (int image = 0; image < 6; ++image) {
    cv::Mat raw(size, CV_16UC1, cv::Scalar(0));
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const int wall = 4 * u / size.width;
        // From 0.7 to 3.3 m: inverse depth is affine over a plane.
        const double z = 1.0 / (1.35 - 0.32 * wall - 0.25 * v / size.height + 0.1 * u / size.width +
                                0.01 * image);
        if (uniform(rng) < holes && v % 20 == 0) continue;
        raw.at<std::uint16_t>(v, u) = cv::saturate_cast<std::uint16_t>(model(z, rng));
      }
    }
    raw.colRange(0, static_cast<int>(holes * size.width)).setTo(0);
    survey.Add(raw);
  }
  return survey.Describe();
}

std::string Best(const DepthStatistics& statistics) {
  const std::vector<DepthGuess> guesses = IdentifyDepthSensor(statistics);
  if (guesses.empty()) return "nothing";
  return std::string(guesses.front().profile->name) + " " +
         std::to_string(std::lround(guesses.front().depth_factor));
}

constexpr double kKinect = 580.0 * 0.075, kD435 = 0.05, kD455 = 0.095;

TEST(DepthSurvey, FindsTheStepsOfInverseDepth) {
  const DepthStatistics kinect = Survey(Triangulating(kKinect, 1.0 / 8.0, 0.1, 1000.0, 5.0));
  ASSERT_TRUE(kinect.inverse_step);
  // The step is 1/8 px, in units of 5000 per metre; the search has steps of 0.2 %.
  EXPECT_NEAR(*kinect.inverse_step * 5000.0, 0.125 / kKinect, 0.003 * 0.125 / kKinect);
  EXPECT_GT(kinect.inverse_step_coherence, 0.7);
  const DepthStatistics d435 = Survey(Triangulating(642 * kD435, 1.0 / 32.0, 0.08, 1000.0, 1.0));
  ASSERT_TRUE(d435.inverse_step);
  EXPECT_NEAR(*d435.inverse_step * 1000.0, 1.0 / 32.0 / 32.1, 0.003 / 32.0 / 32.1);
}

TEST(DepthSurvey, FindsNoStepsWhereDepthIsFine) {
  const DepthStatistics statistics =
      Survey(TimeOfFlight({.offset = 0.002, .quadratic = 0.0005, .reference = 0.0}, 1000.0));
  EXPECT_FALSE(statistics.inverse_step);
  EXPECT_EQ(statistics.unit, 1.0);
}

TEST(DepthSurvey, FindsTheUnitOfMultipliedValues) {
  const DepthNoise noise{.offset = 0.004, .quadratic = 0.0, .reference = 0.0};
  const Model fine = TimeOfFlight(noise, 1000.0);
  const DepthStatistics times5 =
      Survey([&](double z, std::mt19937& rng) { return 5.0 * fine(z, rng); });
  ASSERT_TRUE(times5.unit);
  EXPECT_NEAR(*times5.unit, 5.0, 0.01);
}

TEST(DepthSurvey, MeasuresGrainAndHoles) {
  const DepthNoise noise{.offset = 0.01, .quadratic = 0.0, .reference = 0.0};
  const DepthStatistics statistics = Survey(TimeOfFlight(noise, 1000.0), {320, 240}, 0.2);
  EXPECT_NEAR(statistics.holes, 0.2, 0.02);
  EXPECT_GT(statistics.edge_holes, statistics.holes);
  ASSERT_GE(statistics.grain.size(), 4u);
  // The lower quartile of residuals of 49 pixels lies 7 % below 5 mm; planes within a third of an
  // octave and the rounding to 1 mm add little.
  for (const DepthGrain& grain : statistics.grain) EXPECT_NEAR(grain.sigma, 4.7, 0.5);
}

TEST(DepthSurvey, RefusesOtherImages) {
  DepthSurvey survey;
  EXPECT_THROW(survey.Describe(), InvalidArgument);
  EXPECT_THROW(survey.Add(cv::Mat(4, 4, CV_32FC1)), InvalidArgument);
  survey.Add(cv::Mat(48, 64, CV_16UC1, cv::Scalar(0)));
  EXPECT_THROW(survey.Add(cv::Mat(64, 48, CV_16UC1)), InvalidArgument);
  EXPECT_EQ(survey.Describe().holes, 1.0);
}

TEST(IdentifyDepthSensor, NamesAKinectHoweverItWasStored) {
  EXPECT_EQ(Best(Survey(Triangulating(kKinect, 1.0 / 8.0, 0.1, 1000.0, 5.0))), "kinect1 5000");
  EXPECT_EQ(Best(Survey(Triangulating(kKinect, 1.0 / 8.0, 0.1, 1000.0, 1.0))), "kinect1 1000");
}

TEST(IdentifyDepthSensor, NamesTheRealSenseByItsSteps) {
  const auto real_sense = [](double scale, const cv::Size& size) {
    return Best(Survey(Triangulating(scale, 1.0 / 32.0, 0.05, 1000.0, 1.0, 126.0), size));
  };
  EXPECT_EQ(real_sense(642.0 * kD435, {640, 480}), "d435 1000");
  EXPECT_EQ(real_sense(424.0 * kD435, {320, 240}), "d435 1000");
  EXPECT_EQ(real_sense(384.0 * kD435, {240, 320}), "d435 1000") << "portrait";
  EXPECT_EQ(real_sense(424.0 * kD455, {320, 240}), "d455 1000");
  EXPECT_EQ(real_sense(637.0 * kD455, {640, 360}), "d455 1000");
  EXPECT_EQ(real_sense(950.0 * 0.055, {640, 360}), "d415 1000");
}

TEST(IdentifyDepthSensor, NamesNoTriangulationWhereDepthHasNoSteps) {
  for (const char* name : {"kinect2", "azure", "hololens"}) {
    const SensorProfile& profile = *FindSensorProfile(name);
    const std::vector<DepthGuess> guesses =
        IdentifyDepthSensor(Survey(TimeOfFlight(profile.noise, 1000.0)));
    ASSERT_FALSE(guesses.empty());
    EXPECT_EQ(guesses.front().profile->principle, DepthPrinciple::kTimeOfFlight) << name;
    EXPECT_GT(ProbabilityOfFactor(guesses, 1000.0), 0.5) << name;
  }
}

TEST(IdentifyDepthSensor, AnImageWithoutHolesIsAPhones) {
  const DepthNoise& noise = FindSensorProfile("iphone")->noise;
  EXPECT_EQ(Best(Survey(TimeOfFlight(noise, 1000.0), {256, 192}, 0.0)), "iphone 1000");
  EXPECT_EQ(Best(Survey(TimeOfFlight(noise, 1000.0), {192, 256}, 0.0)), "iphone 1000");
}

TEST(IdentifyDepthSensor, SaysNothingOfImagesThatShowNothing) {
  EXPECT_EQ(Best(Survey([](double, std::mt19937&) { return 0.0; })), "nothing");
  EXPECT_EQ(Best(Survey([](double, std::mt19937&) { return 5000.0; })), "nothing");
}

TEST(IdentifyDepthSensor, ProbabilitiesAddUpToOne) {
  const std::vector<DepthGuess> guesses =
      IdentifyDepthSensor(Survey(Triangulating(kKinect, 1.0 / 8.0, 0.1, 1000.0, 5.0)));
  double sum = 0.0;
  for (const DepthGuess& guess : guesses) sum += guess.probability;
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_NEAR(ProbabilityOfFactor(guesses, 5208.0), ProbabilityOfFactor(guesses, 5000.0), 1e-12);
}

}  // namespace
}  // namespace highwall::depth_identification_test
