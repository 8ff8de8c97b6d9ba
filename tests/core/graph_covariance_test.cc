#include <memory>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

#include "point_observation.h"
#include "random_states.h"

namespace highwall::graph_covariance_test {
namespace {

using Loss = std::shared_ptr<ceres::LossFunction>;

// Observes the x of a point only: the rest of it is unobservable.
struct FirstCoordinate {
  template <class S>
  bool operator()(const S* pose, const S* x, S* r) const {
    r[0] = x[0] - pose[0];
    return true;
  }
};

// Three poses, of which the first is fixed, and eight points that each of them observes.
struct Views {
  // landmarks: whether the points are added as landmarks. Others: poses in the graph that only a
  // prior holds.
  Views(const Loss& loss, bool landmarks, int others = 0) {
    RandomStates random(8);
    for (int i = 0; i < 3; ++i) poses.push_back(graph.AddVariable(random.RandomPose(1.0, 0.5)));
    graph.Fix(poses[0]);
    for (int j = 0; j < 8; ++j) {
      const Point x = random.Vector(4.0);
      points.push_back(landmarks ? graph.AddLandmark(x) : graph.AddVariable(x));
      for (const auto& pose : poses) {
        const Point seen = graph.Value(pose).Inverse() * x + random.Vector(0.05);
        graph.AddFactor(MakeObservation(seen), loss, pose, points.back());
      }
    }
    for (int i = 0; i < others; ++i) {
      const auto other = graph.AddVariable(random.RandomPose());
      graph.AddFactor(std::make_unique<PosePrior>(Pose(), Eigen::Matrix<double, 6, 6>::Identity()),
                      other);
    }
  }

  Eigen::MatrixXd Covariance() const {
    const std::vector<VariableId> ids = {poses[2], poses[0], poses[1]};
    return graph.Covariance(ids).value();
  }

  FactorGraph graph;
  std::vector<Variable<Pose>> poses;
  std::vector<Variable<Point>> points;
};

TEST(GraphCovariance, IsTheSameWhetherLandmarksAreEliminatedOneByOneOrNot) {
  const std::vector<Loss> losses = {nullptr, std::make_shared<ceres::HuberLoss>(0.02)};
  for (const Loss& loss : losses) {
    const Views landmarks(loss, true), all(loss, false);
    EXPECT_TRUE(landmarks.Covariance().isApprox(all.Covariance(), 1e-9));
    // A landmark is requested; then more unknowns than are solved for densely.
    EXPECT_TRUE(landmarks.graph.Covariance(landmarks.points[3])
                    ->isApprox(*all.graph.Covariance(all.points[3]), 1e-9));
    EXPECT_TRUE(Views(loss, true, 70).Covariance().isApprox(all.Covariance(), 1e-9));
  }
}

TEST(GraphCovariance, ContainsTheCurvatureOfAConvexLoss) {
  const auto convex = std::make_shared<ceres::TolerantLoss>(0.05, 0.02);
  const Eigen::MatrixXd landmarks = Views(convex, true).Covariance();
  EXPECT_TRUE(landmarks.isApprox(Views(convex, false).Covariance(), 1e-9));
}

TEST(GraphCovariance, DoesNotMindALandmarkThatIsUnobservable) {
  const Eigen::MatrixXd known = Views(nullptr, true).Covariance();
  for (const bool landmark : {false, true}) {
    Views views(nullptr, true);
    const Point x(1.0, 2.0, 3.0);
    const auto loose = landmark ? views.graph.AddLandmark(x) : views.graph.AddVariable(x);
    EXPECT_TRUE(views.Covariance().isApprox(known, 1e-9));
    views.graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<FirstCoordinate, 1, 7, 3>>(
                              new FirstCoordinate),
                          views.poses[1], loose);
    EXPECT_TRUE(views.Covariance().isApprox(known, 1e-9));
    EXPECT_FALSE(views.graph.Covariance(loose));
  }
}

}  // namespace
}  // namespace highwall::graph_covariance_test
