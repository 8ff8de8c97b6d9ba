#include "inertial/known_point.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "mapped_place.h"

namespace highwall::known_point_test {
namespace {

using testing::MappedPlace;

constexpr double kAnything = 1e9;  // [sigma] no outlier

// Returns half the sum of squares of the keyframes' observations, with the point at p_W.
double CostOfViews(const SeenLandmark<MapPoint>& seen, const MeasurementModel& model,
                   const Eigen::Vector3d& p_W) {
  double cost = 0.0;
  for (const auto& [T_WC, feature] : seen.views) cost += 0.5 * model.Chi2(*feature, T_WC, p_W);
  return cost;
}

double CostOf(const PointInFrame& known, const Eigen::Vector3d& p_W) {
  return 0.5 * (known.sqrt_information() * (p_W - known.p_F())).squaredNorm();
}

std::vector<SeenLandmark<MapPoint>> SeenByTwoOrMore(const SeenLandmarks& all) {
  std::vector<SeenLandmark<MapPoint>> seen;
  for (const SeenLandmark<MapPoint>& one : all.points) {
    if (one.views.size() >= 2) seen.push_back(one);
  }
  EXPECT_GE(seen.size(), 20U);
  return seen;
}

TEST(KnownPoint, HasTheSameCostAsItsViews) {
  MappedPlace place({});
  const MeasurementModel model = place.model();
  const SeenLandmarks all = place.See(testing::kStart);
  const std::vector<SeenLandmark<MapPoint>> seen = SeenByTwoOrMore(all);
  for (const SeenLandmark<MapPoint>& one : seen) {
    const auto known = KnownPoint(one, Pose(), model, kAnything);
    const Eigen::Vector3d& p = one.geometry_W;
    const Eigen::Vector3d step(5e-4, -5e-4, 5e-4);  // [m] a fraction of the uncertainty
    const double views = CostOfViews(one, model, p + step) - CostOfViews(one, model, p - step);
    const double factor = CostOf(*known, p + step) - CostOf(*known, p - step);
    // The factor is of first order; the rest is the curvature of projection over a millimetre.
    EXPECT_NEAR(factor, views, 0.01 * std::abs(views) + 1e-3);
  }
}

TEST(KnownPoint, LiesWhereTheViewsAgree) {
  MappedPlace place({}, 0.0);
  const SeenLandmarks all = place.See(testing::kStart);
  for (SeenLandmark<MapPoint> one : SeenByTwoOrMore(all)) {
    const Eigen::Vector3d truth = one.geometry_W;
    one.geometry_W += Eigen::Vector3d(2e-3, 1e-3, -2e-3);
    // One step of Gauss-Newton leaves the square of a relative error of a thousandth.
    EXPECT_LT((KnownPoint(one, Pose(), place.model(), kAnything)->p_F() - truth).norm(), 3e-5);
  }
}

TEST(KnownPoint, MovesWithTheMap) {
  MappedPlace place({});
  const SeenLandmarks all = place.See(testing::kStart);
  const Pose T_WM = Pose::FromTangent({1, -2, 3}, {0.1, 0.5, -0.3});
  for (const SeenLandmark<MapPoint>& one : SeenByTwoOrMore(all)) {
    const auto here = KnownPoint(one, Pose(), place.model(), kAnything);
    const auto there = KnownPoint(one, T_WM, place.model(), kAnything);
    EXPECT_LT((T_WM * here->p_F() - there->p_F()).norm(), 1e-8);
    const Eigen::Vector3d probe = one.geometry_W + Eigen::Vector3d(0.01, 0.02, 0.03);
    EXPECT_NEAR(CostOf(*here, probe), CostOf(*there, T_WM * probe),
                1e-6 * (1.0 + CostOf(*here, probe)));
  }
}

TEST(KnownPoint, OfOneViewWithoutDepthTheRayStaysOpen) {
  MappedPlace place({}, 0.0);
  const SeenLandmarks all = place.See(testing::kStart);
  const std::vector<SeenLandmark<MapPoint>> seen = SeenByTwoOrMore(all);
  ASSERT_FALSE(seen.empty());
  SeenLandmark<MapPoint> one = seen.front();
  PointFeature flat = *one.views.front().feature;
  flat.depth = 0.0;
  one.views = {{one.views.front().T_WC, &flat}};
  const Eigen::Vector3d ray = (one.geometry_W - one.views.front().T_WC.p()).normalized();
  const auto known = KnownPoint(one, Pose(), place.model(), kAnything);
  const Eigen::Matrix3d W = known->sqrt_information();
  EXPECT_GT(W.norm(), 10.0);                     // [1/m]
  EXPECT_LT((W * ray).norm(), 1e-6 * W.norm());  // rounding of the unobservable direction
  EXPECT_LT((known->p_F() - one.geometry_W).norm(), 1e-5);
}

TEST(KnownPoint, AnOutlierWeighsLittle) {
  MappedPlace place({}, 0.0);
  const SeenLandmarks all = place.See(testing::kStart);
  std::vector<SeenLandmark<MapPoint>> seen = SeenByTwoOrMore(all);
  std::erase_if(seen, [](const SeenLandmark<MapPoint>& one) { return one.views.size() < 4; });
  ASSERT_FALSE(seen.empty());
  SeenLandmark<MapPoint> one = seen.front();
  PointFeature wrong = *one.views.front().feature;
  wrong.uv.x() += 30.0;  // [px]
  one.views.front().feature = &wrong;
  const auto off = [&](double huber) {
    return (KnownPoint(one, Pose(), place.model(), huber)->p_F() - one.geometry_W).norm();
  };
  EXPECT_LT(off(2.8), 0.2 * off(kAnything));
}

}  // namespace
}  // namespace highwall::known_point_test
