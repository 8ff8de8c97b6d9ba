#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include <Eigen/Core>

#include <highwall/core/pose_graph.h>

// Generated pose graphs with their truth: seeded noise with the covariance stated by the edges.
namespace highwall {

class PoseGraphScene {
 public:
  PoseGraphScene(PoseGraphSpace space, unsigned seed) : rng_(seed) { truth.space = space; }

  PoseGraph truth;     // the true poses, noisy edges
  double noise = 1.0;  // factor on the standard deviations of the edges; 0: exact edges

  void AddNode(const Pose& pose) {
    truth.nodes.push_back({static_cast<std::int64_t>(truth.nodes.size()), pose});
  }
  // Adds odometry between a node and the next one, or a loop.
  void AddEdge(std::int64_t i, std::int64_t j) {
    constexpr double kPosition = 0.05, kAngle = 0.02;  // [m] [rad]
    const bool planar = truth.space == PoseGraphSpace::kSe2;
    Eigen::Matrix<double, 6, 1> step;
    for (int k = 0; k < 6; ++k) {
      step[k] = noise * (k < 3 ? kPosition : kAngle) * std::normal_distribution<double>()(rng_);
    }
    if (planar) step[2] = step[3] = step[4] = 0.0;
    const Pose Z_true = At(i).Inverse() * At(j);
    PoseGraphEdge edge;
    edge.i = i;
    edge.j = j;
    edge.kind = j == i + 1 ? PoseGraphEdgeKind::kOdometry : PoseGraphEdgeKind::kLoop;
    edge.Z = Z_true * Pose::FromTangent(step.head<3>(), step.tail<3>());
    if (planar) {
      const double half = std::atan2(edge.Z.q().z(), edge.Z.q().w());
      edge.Z = Pose(Eigen::Quaterniond(std::cos(half), 0.0, 0.0, std::sin(half)),
                    {edge.Z.p().x(), edge.Z.p().y(), 0.0});
    }
    Eigen::Matrix<double, 6, 1> weights;
    weights.head<3>().setConstant(1.0 / (kPosition * kPosition));
    weights.tail<3>().setConstant(1.0 / (kAngle * kAngle));
    edge.information = planar ? PoseInformation(weights.segment<3>(1).asDiagonal())
                              : PoseInformation(weights.asDiagonal());
    if (planar) edge.information.diagonal() << weights[0], weights[1], weights[5];
    truth.edges.push_back(edge);
  }
  const Pose& At(std::int64_t id) const { return truth.nodes[static_cast<std::size_t>(id)].pose; }

 private:
  std::mt19937 rng_;
};

// Laps of 20 poses up a sphere, with edges from every pose to those of the neighbouring laps.
inline PoseGraph MakeSphere(unsigned seed, double noise = 1.0, int laps = 8) {
  constexpr int kPerLap = 20;
  constexpr double kRadius = 5.0;  // [m]
  PoseGraphScene scene(PoseGraphSpace::kSe3, seed);
  scene.noise = noise;
  for (int k = 0; k < laps * kPerLap; ++k) {
    const double longitude = 2.0 * M_PI * k / kPerLap;
    const double latitude = M_PI * (k + 1.0) / (laps * kPerLap + 1.0) - 0.5 * M_PI;
    const Eigen::Vector3d p(std::cos(latitude) * std::cos(longitude),
                            std::cos(latitude) * std::sin(longitude), std::sin(latitude));
    scene.AddNode(Pose::FromTangent(kRadius * p, Eigen::Vector3d(0.0, -latitude, 0.0)));
  }
  for (int k = 1; k < laps * kPerLap; ++k) scene.AddEdge(k - 1, k);
  for (int k = kPerLap; k < laps * kPerLap; ++k) scene.AddEdge(k - kPerLap, k);
  return scene.truth;
}

// Rows of a field traversed up and down, with edges to the neighbouring rows.
inline PoseGraph MakeField(unsigned seed, double noise = 1.0, int rows = 8) {
  constexpr int kPerRow = 12;
  PoseGraphScene scene(PoseGraphSpace::kSe2, seed);
  scene.noise = noise;
  for (int k = 0; k < rows * kPerRow; ++k) {
    const int row = k / kPerRow, column = k % kPerRow;
    const bool back = row % 2 == 1;
    scene.AddNode(
        Pose(back ? Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0) : Eigen::Quaterniond::Identity(),
             {static_cast<double>(back ? kPerRow - 1 - column : column), static_cast<double>(row),
              0.0}));
  }
  for (int k = 1; k < rows * kPerRow; ++k) scene.AddEdge(k - 1, k);
  for (int k = kPerRow; k < rows * kPerRow; ++k) {
    const int row = k / kPerRow, column = k % kPerRow;
    const int across = (row - 1) * kPerRow + (kPerRow - 1 - column);
    if (across != k - 1) scene.AddEdge(across, k);
  }
  return scene.truth;
}

inline std::size_t CountLoops(const PoseGraph& graph) {
  return static_cast<std::size_t>(std::count_if(graph.edges.begin(), graph.edges.end(),
                                                [](const auto& e) { return e.IsLoop(); }));
}

}  // namespace highwall
