#include "system/chain_covariance.h"

#include <cstddef>
#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>

namespace highwall::chain_covariance_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// r = J x + c of blocks of any sizes.
class LinearFactor final : public ceres::CostFunction {
 public:
  LinearFactor(MatrixXd J, VectorXd c, const std::vector<int>& sizes)
      : J_(std::move(J)), c_(std::move(c)) {
    set_num_residuals(static_cast<int>(c_.size()));
    mutable_parameter_block_sizes()->assign(sizes.begin(), sizes.end());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    VectorXd r = c_;
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
      const int size = parameter_block_sizes()[i];
      const auto J = J_.middleCols(column, size);
      r += J * Eigen::Map<const VectorXd>(parameters[i], size);
      if (jacobians != nullptr && jacobians[i] != nullptr) {
        if (size == 1) {
          Eigen::Map<VectorXd>(jacobians[i], r.size()) = J;
        } else {
          Eigen::Map<RowMajor>(jacobians[i], r.size(), size) = J;
        }
      }
      column += size;
    }
    Eigen::Map<VectorXd>(residuals, r.size()) = r;
    return true;
  }

 private:
  const MatrixXd J_;
  const VectorXd c_;
};

// States of a pose and a velocity, each measured with a Huber loss and tied to the one before it
// and to two common numbers.
struct Chain {
  using Common = Eigen::Vector2d;

  Chain(int length, bool has_common, int missing = -1) {
    std::mt19937 rng(length);
    const auto random = [&rng](int rows, int columns) {
      std::uniform_real_distribution<double> uniform(-1.0, 1.0);
      MatrixXd m(rows, columns);
      for (double& x : m.reshaped()) x = uniform(rng);
      return m;
    };
    const auto loss = std::make_shared<ceres::HuberLoss>(0.5);
    if (has_common) common.push_back(graph.AddVariable<Common>(random(2, 1)));
    for (int i = 0; i < length; ++i) {
      poses.push_back(
          graph.AddVariable(Pose::FromTangent(random(3, 1).col(0), random(3, 1).col(0))));
      velocities.push_back(graph.AddVariable<Eigen::Vector3d>(random(3, 1).col(0)));
      const Pose measured = Pose::FromTangent(random(3, 1).col(0), random(3, 1).col(0));
      graph.AddFactor(std::make_unique<PosePrior>(measured, 3.0 * random(6, 6)), loss, poses[i]);
      if (i == missing) continue;
      std::vector<VariableId> of_factor = {velocities[i]};
      if (i > 0) of_factor.insert(of_factor.end(), {poses[i], velocities[i - 1], poses[i - 1]});
      if (has_common) of_factor.push_back(common.front());
      std::vector<int> sizes;
      for (const VariableId& id : of_factor) {
        sizes.push_back(graph.problem().ParameterBlockSize(graph.Block(id)));
      }
      const int columns = std::accumulate(sizes.begin(), sizes.end(), 0);
      graph.AddFactorToBlocks(
          std::make_shared<LinearFactor>(random(7, columns), random(7, 1), sizes), loss, of_factor);
    }
  }

  std::vector<MatrixXd> Covariances() {
    std::vector<std::vector<double*>> states;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      states.push_back({graph.MutableBlock(velocities[i]), graph.MutableBlock(poses[i])});
    }
    std::vector<double*> of_all;
    for (const VariableId& id : common) of_all.push_back(graph.MutableBlock(id));
    return ChainCovariance(graph.problem(), states, of_all);
  }

  FactorGraph graph;
  std::vector<Variable<Pose>> poses;
  std::vector<Variable<Eigen::Vector3d>> velocities;
  std::vector<Variable<Common>> common;
};

void ExpectThoseOfTheGraph(Chain chain) {
  const std::vector<MatrixXd> covariances = chain.Covariances();
  ASSERT_EQ(covariances.size(), chain.poses.size());
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    const std::vector<VariableId> state = {chain.velocities[i], chain.poses[i]};
    const MatrixXd expected = chain.graph.Covariance(state).value();
    // Rounding of matrices whose condition is up to 1e5.
    EXPECT_LT((covariances[i] - expected).norm(), 1e-9 * expected.norm()) << i;
  }
}

TEST(ChainCovariance, IsThatOfTheWholeGraph) {
  ExpectThoseOfTheGraph(Chain(20, false));
}

TEST(ChainCovariance, BlocksThatAllStatesShareAreEstimatedAsWell) {
  ExpectThoseOfTheGraph(Chain(21, true));
}

TEST(ChainCovariance, AConstantBlockIsKnown) {
  Chain chain(9, true);
  const std::vector<VariableId> fifth = {chain.velocities[4], chain.poses[4]};
  const MatrixXd before = chain.graph.Covariance(fifth).value();
  chain.graph.Fix(chain.common.front());
  chain.common.clear();
  EXPECT_LT(chain.Covariances()[4].trace(), before.trace());
  ExpectThoseOfTheGraph(std::move(chain));
}

TEST(ChainCovariance, OfOneStateIsThatOfTheGraph) {
  Chain chain(1, false);
  chain.graph.AddFactor(
      std::make_unique<VectorPrior<3>>(Eigen::Vector3d(1, 2, 3), 2.0 * Eigen::Matrix3d::Identity()),
      chain.velocities[0]);
  ExpectThoseOfTheGraph(std::move(chain));
}

TEST(ChainCovariance, IsEmptyIfADirectionIsNotObservable) {
  EXPECT_FALSE(Chain(5, false).Covariances().empty());
  EXPECT_TRUE(Chain(5, false, 4).Covariances().empty()) << "nothing states the last velocity";
}

}  // namespace
}  // namespace highwall::chain_covariance_test
