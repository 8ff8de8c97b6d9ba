// Where is the camera that sees four known points? Exits 0 if the answer is right.
#include <memory>

#include <highwall/core/camera.h>
#include <highwall/core/factor_graph.h>
#include <highwall/factors/point_reprojection.h>

int main() {
  using namespace highwall;
  const PinholeCamera camera;
  const RgbdProjection projection(camera, Pose());  // the body is the camera
  const Pose truth = Pose::FromTangent({0.1, 0.0, -0.2}, {0.0, 0.05, 0.0});

  FactorGraph graph;
  const Variable<Pose> T_WB = graph.AddVariable(Pose());
  for (const Point& p_W : {Point(-1, -1, 3), Point(1, -1, 3), Point(0, 1, 2), Point(1, 0, 4)}) {
    const Variable<Point> point = graph.AddVariable(p_W);
    graph.Fix(point);
    const Eigen::Vector2d uv = camera.Project(truth.Inverse() * p_W);  // [px]
    graph.AddFactor(
        std::make_unique<PointReprojection>(uv, Eigen::Matrix2d::Identity(), projection), T_WB,
        point);
  }
  const SolveSummary summary = graph.Solve();
  const bool right = (graph.Value(T_WB).p() - truth.p()).norm() < 1e-6;
  return summary.IsUsable() && right ? 0 : 1;
}
