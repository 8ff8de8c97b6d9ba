#include <highwall/core/marginalization.h>

#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/so3.h>

#include "point_observation.h"
#include "random_states.h"

// A visual-inertial window of poses, velocities and points without any absolute measurement:
// gravity gives roll and pitch, and position and yaw stay unobservable.
namespace highwall::visual_inertial_null_space_test {
namespace {

const Eigen::Vector3d kGravity(0, 0, -9.81);
constexpr double kStep = 0.1;  // [s] between states

// Preintegrated motion from i to j: r = R_i^T (v_j - v_i - g dt) - dv, and likewise for the rest.
struct Motion {
  Eigen::Quaterniond dR;
  Eigen::Vector3d dv, dp;
  template <class S>
  bool operator()(const S* T_i, const S* v_i, const S* T_j, const S* v_j, S* residuals) const {
    using Vector = Eigen::Matrix<S, 3, 1>;
    const Eigen::Map<const Vector> p_i(T_i), p_j(T_j), vi(v_i), vj(v_j);
    const Eigen::Map<const Eigen::Quaternion<S>> q_i(T_i + 3), q_j(T_j + 3);
    const S dt(kStep);
    const Vector g = kGravity.cast<S>();
    Eigen::Map<Eigen::Matrix<S, 9, 1>> r(residuals);
    r.template segment<3>(0) =
        (q_i.conjugate() * (p_j - p_i - vi * dt - g * (S(0.5) * dt * dt)) - dp.cast<S>()) * S(200);
    r.template segment<3>(3) =
        (dR.conjugate().cast<S>() * (q_i.conjugate() * q_j)).vec() * S(2.0 * 200.0);
    r.template segment<3>(6) = (q_i.conjugate() * (vj - vi - g * dt) - dv.cast<S>()) * S(50);
    return true;
  }
};

struct State {
  Pose T;
  Eigen::Vector3d v;
};

State Truth(int k) {
  const double t = kStep * k;
  const Eigen::Vector3d p(2.0 * std::cos(0.5 * t), 2.0 * std::sin(0.5 * t), 0.3 * std::sin(t));
  const Eigen::Vector3d v(-std::sin(0.5 * t), std::cos(0.5 * t), 0.3 * std::cos(t));
  return {Pose::FromTangent(p, {0.2 * std::sin(t), 0.2 * std::cos(0.7 * t), 0.5 * t}), v};
}

struct Leak {
  double translation = 0.0;  // largest |A n| / (|A| |n|) over the marginalizations
  double yaw = 0.0;
};

// Measures the information of the prior along the unobservable directions at its linearization
// points.
Leak Measure(const MarginalPrior& prior) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(prior.A().cols(), 4);
  for (std::size_t i = 0; i < prior.blocks().size(); ++i) {
    const Eigen::Index c = prior.Column(i);
    const double* x = prior.blocks()[i].linearization_point.data();
    const Eigen::Vector3d head(x[0], x[1], x[2]);
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    N.block<3, 1>(c, 3) = up.cross(head);  // a position, point or velocity rotates about z
    if (prior.blocks()[i].manifold != nullptr) {
      N.block<3, 3>(c, 0).setIdentity();
      N.block<3, 1>(c + 3, 3) = Pose::FromBlock(x).R().transpose() * up;
    }
  }
  const double norm = prior.A().norm();
  Leak leak;
  for (int k = 0; k < 3; ++k) {
    leak.translation =
        std::max(leak.translation, (prior.A() * N.col(k)).norm() / (norm * N.col(k).norm()));
  }
  leak.yaw = (prior.A() * N.col(3)).norm() / (norm * N.col(3).norm());
  return leak;
}

class Window {
 public:
  explicit Window(const MarginalizationOptions& options) : options_(options), random_(7) {}

  void AddState(int k) {
    const State truth = Truth(k);
    const Eigen::Matrix<double, 6, 1> noise = 0.02 * random_.Matrix<6>().col(0);
    poses_.push_back(graph_.AddVariable(truth.T.Plus(noise)));
    velocities_.push_back(graph_.AddVariable(Eigen::Vector3d(truth.v + random_.Vector(0.05))));
    if (k > 0) {
      const State before = Truth(k - 1);
      const Eigen::Quaterniond R_t = before.T.q().conjugate();
      const Motion motion{
          R_t * truth.T.q() * so3::Exp(random_.Vector(0.01)),
          R_t * (truth.v - before.v - kGravity * kStep) + random_.Vector(0.02),
          R_t * (truth.T.p() - before.T.p() - before.v * kStep - kGravity * 0.5 * kStep * kStep) +
              random_.Vector(0.01)};
      const std::size_t j = poses_.size() - 1;
      graph_.AddFactor(
          std::make_unique<ceres::AutoDiffCostFunction<Motion, 9, 7, 3, 7, 3>>(new Motion(motion)),
          poses_[j - 1], velocities_[j - 1], poses_[j], velocities_[j]);
    }
    // One new point is added, and each is observed from six states. Points are plain variables, so
    // the prior links them.
    truths_.emplace_back(truth.T * random_.Vector(3.0));
    points_.push_back(graph_.AddVariable(Point(truths_.back() + random_.Vector(0.1))));
    for (std::size_t i = points_.size() - std::min<std::size_t>(6, points_.size());
         i < points_.size(); ++i) {
      const Eigen::Vector3d z = truth.T.Inverse() * truths_[i] + random_.Vector(0.05);
      graph_.AddFactor(MakeObservation(z, 50.0), poses_.back(), points_[i]);
    }
  }

  // Removes the oldest state and the oldest point.
  void RemoveOldest() {
    const std::vector<VariableId> removed = {poses_.front(), velocities_.front(), points_.front()};
    std::vector<double*> blocks;
    for (const VariableId& id : removed) blocks.push_back(graph_.MutableBlock(id));
    Marginal marginal = Marginalize(graph_.problem(), blocks, options_);
    for (const VariableId& id : removed) graph_.Remove(id);
    const Leak now = Measure(*marginal.prior);
    leak_.translation = std::max(leak_.translation, now.translation);
    leak_.yaw = std::max(leak_.yaw, now.yaw);
    std::vector<VariableId> kept;
    for (const double* block : marginal.blocks) kept.push_back(graph_.FindVariable(block));
    graph_.AddFactorToBlocks(std::move(marginal.prior), nullptr, kept);
    poses_.pop_front();
    velocities_.pop_front();
    points_.pop_front();
    truths_.pop_front();
  }

  // Null space of the whole window, prior and factors together.
  int NullSpace() {
    std::vector<double*> blocks;
    graph_.problem().GetParameterBlocks(&blocks);
    return Summarize(graph_.problem(), blocks, options_).report.null_space;
  }

  std::size_t size() const { return poses_.size(); }
  FactorGraph& graph() { return graph_; }
  const Leak& leak() const { return leak_; }

 private:
  MarginalizationOptions options_;
  RandomStates random_;
  FactorGraph graph_;
  std::deque<Variable<Pose>> poses_;
  std::deque<Variable<Eigen::Vector3d>> velocities_;
  std::deque<Variable<Point>> points_;
  std::deque<Eigen::Vector3d> truths_;
  Leak leak_;
};

struct Outcome {
  Leak leak;
  int null_space = 0;  // of the last window
};

Outcome Marginalize200Times(bool first_estimate_jacobians) {
  Window window({.first_estimate_jacobians = first_estimate_jacobians});
  Outcome outcome;
  for (int k = 0, marginalized = 0; marginalized < 200; ++k) {
    window.AddState(k);
    EXPECT_TRUE(window.graph().Solve({.max_iterations = 5}).IsUsable());
    if (window.size() <= 6) continue;
    window.RemoveOldest();
    ++marginalized;
  }
  outcome.leak = window.leak();
  outcome.null_space = window.NullSpace();
  return outcome;
}

TEST(VisualInertialNullSpace, KeepsZeroInformationWithFirstEstimateJacobians) {
  const Outcome outcome = Marginalize200Times(true);
  // Rounding of 200 QR decompositions.
  EXPECT_LT(outcome.leak.translation, 1e-12);
  EXPECT_LT(outcome.leak.yaw, 1e-12);
  EXPECT_EQ(outcome.null_space, 4);
}

TEST(VisualInertialNullSpace, LeaksYawWithoutFirstEstimateJacobians) {
  const Outcome outcome = Marginalize200Times(false);
  // Translation does not depend on the linearization points.
  EXPECT_LT(outcome.leak.translation, 1e-9);
  EXPECT_GT(outcome.leak.yaw, 1e-5);
  EXPECT_EQ(outcome.null_space, 3);  // yaw appears observable
}

}  // namespace
}  // namespace highwall::visual_inertial_null_space_test
