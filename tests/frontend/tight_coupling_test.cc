#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial/tight_coupling.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "mapped_place.h"

namespace highwall::tight_coupling_test {
namespace {

using testing::kImageStep;
using testing::kStart;
using testing::MappedPlace;

// Images every kImageStep, given to the coupling with their readings.
class TightCouplingTest : public ::testing::Test {
 protected:
  TightCouplingTest() : place_({}) { options_.tight.max_points = 30, options_.tight.max_lines = 5; }

  void Begin(bool background = true) {
    for (const ImuSample& reading : place_.scene().Readings(0.0, kStart)) buffer_.Add(reading);
    const InertialPrior prior = testing::Start(place_.scene(), kStart, 0.0, {.t_d = 1e-6});
    newest_ = prior.estimate.stamp;
    coupling_.emplace(
        options_,
        *VisualInertialWindow::Make(place_.scene().calibration(), place_.model(), options_, prior),
        background);
  }
  // Returns the stamp of the image; dark: it shows nothing. weight: of its readings. time_offset:
  // [s] from its stamp to the end of the readings.
  Stamp Feed(bool dark = false, double weight = 1.0, double time_offset = 0.0) {
    const double t = kStart + kImageStep * ++image_;
    for (const ImuSample& reading : place_.scene().Readings(read_ + 0.005, t + 0.05)) {
      buffer_.Add(reading);
    }
    read_ = t + 0.05;
    const Stamp to = FromSeconds(t);
    const ImuPreintegration imu(buffer_.Between(newest_, to)->samples, ImuBias::Zero());
    newest_ = to;
    const std::function<SeenLandmarks()> see = [this, t] {
      ++asked_;
      return place_.See(t);
    };
    coupling_->Add(
        {.imu = imu, .weight = weight, .visual = std::nullopt, .time_offset = time_offset}, Pose(),
        dark ? nullptr : see);
    return to;
  }
  TightCoupling::Result Await() {
    while (true) {
      if (auto result = coupling_->Take()) return *std::move(result);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  MappedPlace place_;
  InertialOptions options_;
  std::optional<TightCoupling> coupling_;
  int asked_ = 0;

 private:
  ImuBuffer buffer_;
  Stamp newest_ = 0;
  int image_ = 0;
  double read_ = kStart;
};

TEST_F(TightCouplingTest, InSynchronousModeTheResultOfAnImageIsThereAtOnce) {
  Begin(false);
  for (int k = 0; k < 3; ++k) {
    const Stamp stamp = Feed();
    const auto result = coupling_->Take();
    ASSERT_TRUE(result && result->prior);
    EXPECT_EQ(result->prior->estimate.stamp, stamp);
    EXPECT_TRUE(result->since.empty());
    EXPECT_FALSE(coupling_->Take()) << "once";
  }
}

TEST_F(TightCouplingTest, ARejectedStepHasAReason) {
  Begin();
  Feed();
  const TightCoupling::Result good = Await();
  EXPECT_TRUE(good.update.accepted);
  EXPECT_EQ(good.update.reason, "");
  Feed(false, 1e308);  // the squares of such residuals are not finite
  const TightCoupling::Result bad = Await();
  EXPECT_FALSE(bad.update.accepted);
  EXPECT_FALSE(bad.prior);
  EXPECT_NE(bad.update.reason.find("ImuGravityFactor"), std::string::npos) << bad.update.reason;
}

TEST_F(TightCouplingTest, MisuseIsAnErrorAfterWhichTheSmootherMustBeRestarted) {
  Begin(/*background=*/true);
  Feed(false, 1.0, NAN);
  EXPECT_THROW(Await(), InvalidArgument);
  EXPECT_FALSE(Await().update.accepted);

  Begin(/*background=*/false);
  EXPECT_THROW(Feed(false, 1.0, NAN), InvalidArgument);
  EXPECT_FALSE(Await().update.accepted);
}

TEST_F(TightCouplingTest, LandmarksAreAskedForWhereItIsTimeForAState) {
  options_.tight.interval = 3 * kImageStep;
  Begin(false);
  for (int k = 1; k <= 9; ++k) {
    const Stamp stamp = Feed();
    const auto result = coupling_->Take();
    EXPECT_EQ(asked_, k / 3);
    ASSERT_EQ(result.has_value(), k % 3 == 0);
    if (!result) continue;
    EXPECT_EQ(result->prior->estimate.stamp, stamp);
  }
}

TEST_F(TightCouplingTest, InTheDarkReadingsAddUp) {
  Begin(false);
  Feed();
  ASSERT_TRUE(coupling_->Take());
  for (int k = 0; k < 5; ++k) {
    Feed(true);
    EXPECT_FALSE(coupling_->Take());
  }
  const Stamp light = Feed();
  const auto result = coupling_->Take();
  ASSERT_TRUE(result && result->prior);
  EXPECT_EQ(result->prior->estimate.stamp, light);
}

TEST_F(TightCouplingTest, HandsBackWhatArrivesDuringTheWork) {
  Begin();
  const Stamp first = Feed();
  Feed();
  const Stamp last = Feed();
  const TightCoupling::Result result = Await();
  ASSERT_TRUE(result.prior);
  EXPECT_EQ(result.prior->estimate.stamp, first);
  ASSERT_EQ(result.since.size(), 2u);
  EXPECT_EQ(result.since[0].imu.start(), first);
  EXPECT_EQ(result.since[1].imu.end(), last);
  EXPECT_EQ(asked_, 1);
}

// Odometry of a body in a mapped place, with delayed images.
class CoupledOdometry : public ::testing::TestWithParam<bool> {
 protected:
  static InertialOptions Options() {
    InertialOptions options;
    options.tight.max_points = 60, options.tight.max_lines = 10;
    return options;
  }
};

// Processes ninety images, ten of them dark; returns the pose of the map's world in that of the
// place.
Pose Follow(MappedPlace& place, InertialOdometry& odometry) {
  constexpr double kStep = 0.05;
  double read = -0.005;
  Pose T_gravity;
  for (int k = 1; k <= 90; ++k) {
    const double t = kStep * k;
    for (const ImuSample& reading : place.scene().Readings(read + 0.005, t + 0.1)) {
      odometry.AddSample(reading);
    }
    read = t + 0.1;
    InertialOdometry::Observation observation;
    observation.image = FromSeconds(t);
    const bool dark = k > 60 && k <= 70;
    if (!dark) observation.visual = Moved(place.scene().See(t), T_gravity);
    observation.see = [&] { return place.See(t); };
    const InertialReport report = odometry.Update(observation);
    if (report.T_gravity) {
      T_gravity = *report.T_gravity * T_gravity;
      place.MoveMap(*report.T_gravity);
    }
  }
  return T_gravity;
}

TEST_P(CoupledOdometry, FindsPoseVelocityAndTimeOffset) {
  constexpr double kOffset = 0.012;
  MappedPlace place({.time_offset = kOffset, .seed = 5});
  InertialOdometry odometry(place.scene().calibration(), Options(), place.model(), GetParam());
  const Pose T_gravity = Follow(place, odometry);
  ASSERT_EQ(odometry.status(), InertialStatus::kRunning);
  const InertialEstimate estimate = *odometry.estimate();
  const ImuState truth = place.scene().StateAt(ToSeconds(estimate.stamp));
  EXPECT_NEAR(odometry.time_offset(), kOffset, 1e-3);
  EXPECT_LT((T_gravity * truth.T_WB.p() - estimate.state.T_WB.p()).norm(), 3e-3);
  EXPECT_LT((T_gravity.q() * truth.v_WB - estimate.state.v_WB).norm(), 0.02);
}

TEST_P(CoupledOdometry, FindsWhereTheCameraSits) {
  MappedPlace place({.seed = 5});
  ImuCalibration calibration = place.scene().calibration();
  const Pose truth = calibration.T_BC;
  calibration.T_BC = truth * Pose::FromTangent({0.006, -0.006, 0.006}, {0.01, 0.01, -0.01});
  InertialOptions options = Options();
  options.estimate_extrinsics = true;
  InertialOdometry odometry(calibration, options, place.model(), GetParam());
  Follow(place, odometry);
  ASSERT_EQ(odometry.status(), InertialStatus::kRunning);
  const Pose error = truth.Inverse() * odometry.T_BC();
  // The initial error is 17 mrad; four seconds of motion hardly constrain the position, known to 10
  // mm on each axis before.
  EXPECT_LT(error.Angle(), 4e-3);
  EXPECT_LT(error.p().norm(), 0.02);
}

INSTANTIATE_TEST_SUITE_P(SynchronousAndInTheBackground, CoupledOdometry, ::testing::Bool());

TEST_F(TightCouplingTest, CancelledWorkEndsEarly) {
  options_.tight.max_points = 2000, options_.tight.max_lines = 200;
  Begin();
  for (int k = 0; k < 3; ++k) {  // after which the window has states and landmarks
    Feed();
    ASSERT_TRUE(Await().update.accepted);
  }
  // On a busy machine the work may be done before it can be cancelled.
  TightUpdate update{.accepted = true};
  for (int attempt = 0; update.accepted && attempt < 50; ++attempt) {
    Feed();
    coupling_->Cancel();
    update = Await().update;
  }
  EXPECT_EQ(update.reason, "it was stopped");
}

}  // namespace
}  // namespace highwall::tight_coupling_test
