#pragma once

#include <random>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>

// Seeded random states for the tests of core.
namespace highwall {

class RandomStates {
 public:
  explicit RandomStates(unsigned seed) : rng_(seed) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Eigen::Vector3d Vector(double bound) {
    return {Uniform(-bound, bound), Uniform(-bound, bound), Uniform(-bound, bound)};
  }
  Eigen::Vector3d Direction() {
    Eigen::Vector3d v = Vector(1.0);
    while (v.norm() < 0.1) v = Vector(1.0);
    return v.normalized();
  }
  // Positions within `bound` [m], rotations up to `max_angle` [rad].
  Pose RandomPose(double bound = 2.0, double max_angle = 3.0) {
    return Pose::FromTangent(Vector(bound), Direction() * Uniform(0.0, max_angle));
  }
  template <int N>
  Eigen::Matrix<double, N, N> Matrix() {
    Eigen::Matrix<double, N, N> m;
    for (int i = 0; i < N * N; ++i) m.data()[i] = Uniform(-1.0, 1.0);
    return m;
  }

 private:
  std::mt19937 rng_;
};

inline std::vector<double> Block(const Pose& pose) {
  return {pose.data(), pose.data() + Pose::kSize};
}

}  // namespace highwall
