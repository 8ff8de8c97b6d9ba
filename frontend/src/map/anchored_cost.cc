#include "map/anchored_cost.h"

#include <algorithm>

#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

using RowMajor7 = Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>;

}  // namespace

AnchoredCost::AnchoredCost(const MapFactor& factor, const Pose& T_XC) : cost_(factor.cost) {
  for (const AnchoredBodyPose& pose : factor.poses) {
    auto found = std::find(keyframes_.begin(), keyframes_.end(), pose.keyframe);
    if (found == keyframes_.end()) found = keyframes_.insert(found, pose.keyframe);
    bodies_.push_back({static_cast<std::size_t>(found - keyframes_.begin()), T_XC * pose.T_KB});
  }
  set_num_residuals(cost_->num_residuals());
  const std::size_t others = cost_->parameter_block_sizes().size() - bodies_.size();
  mutable_parameter_block_sizes()->assign(keyframes_.size() + others, Pose::kSize);
}

bool AnchoredCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const std::size_t others = parameter_block_sizes().size() - keyframes_.size();
  std::vector<Pose> poses;
  std::vector<const double*> blocks;
  std::vector<RowMajor7> of_bodies(bodies_.size());
  std::vector<double*> inner(bodies_.size() + others, nullptr);
  poses.reserve(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const std::size_t block = bodies_[i].block;
    poses.push_back(Pose::FromBlock(parameters[block]) * bodies_[i].T_XB);
    blocks.push_back(poses.back().data());
    if (jacobians == nullptr || jacobians[block] == nullptr) continue;
    of_bodies[i].resize(num_residuals(), 7);
    inner[i] = of_bodies[i].data();
  }
  for (std::size_t i = 0; i < others; ++i) {
    blocks.push_back(parameters[keyframes_.size() + i]);
    if (jacobians != nullptr) inner[bodies_.size() + i] = jacobians[keyframes_.size() + i];
  }
  if (!cost_->Evaluate(blocks.data(), residuals, jacobians != nullptr ? inner.data() : nullptr)) {
    return false;
  }
  if (jacobians == nullptr) return true;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    if (jacobians[k] != nullptr) std::fill_n(jacobians[k], 7 * num_residuals(), 0.0);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const std::size_t block = bodies_[i].block;
    if (inner[i] == nullptr) continue;
    Chain(bodies_[i], parameters[block], blocks[i], inner[i], jacobians[block]);
  }
  return true;
}

void AnchoredCost::Chain(const Body& body, const double* T_WX, const double* T_WB,
                         const double* of_body, double* of_keyframe) const {
  Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
  PoseManifold().PlusJacobian(T_WB, plus.data());
  const Eigen::Matrix3d R_WX = Pose::FromBlock(T_WX).R();
  const Eigen::Matrix3d turn = -R_WX * so3::Hat(body.T_XB.p());
  const Eigen::Matrix3d R_BX = body.T_XB.R().transpose();
  const Eigen::Map<const RowMajor7> ambient(of_body, num_residuals(), 7);
  for (int row = 0; row < num_residuals(); ++row) {
    const Eigen::Matrix<double, 1, 6> J = ambient.row(row) * plus;
    Eigen::Matrix<double, 1, 6> chained;
    chained << J.leftCols<3>(), J.leftCols<3>() * turn + J.rightCols<3>() * R_BX;
    Eigen::Matrix<double, 1, 7> lifted;
    PoseManifold::Lift<1>(T_WX, chained, lifted.data());
    Eigen::Map<Eigen::Matrix<double, 1, 7>>(of_keyframe + 7 * row) += lifted;
  }
}

std::vector<const MapFactor*> FactorsIn(const Map& map, SubmapId submap) {
  const SubmapId root = map.Root(submap), first = map.Root(kFirstSubmap);
  const auto is_effective = [&](const MapFactor& factor) {
    if (factor.frame != kNoId) return map.factors().T_FW(factor.frame, root).has_value();
    return factor.poses.size() > 1 || root == first;
  };
  std::vector<const MapFactor*> factors;
  for (const MapFactor& factor : map.factors().all()) {
    const bool inside = std::ranges::all_of(factor.poses, [&](const AnchoredBodyPose& pose) {
      return map.Root(map.keyframe(pose.keyframe)->submap) == root;
    });
    if (inside && is_effective(factor)) factors.push_back(&factor);
  }
  return factors;
}

double UprightSigma(const Map& map, SubmapId submap) {
  constexpr double kByGravity = 0.01, kByHand = 0.3;
  return map.gravity_W(submap) ? kByGravity : kByHand;
}

}  // namespace highwall
