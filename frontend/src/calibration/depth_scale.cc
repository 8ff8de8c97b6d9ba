#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/scaled_motion.h>
#include <highwall/frontend/calibration/depth_scale.h>
#include <highwall/frontend/local/bundle_adjustment.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace highwall {
namespace {

constexpr std::size_t kShortestChain = 3;  // two keyframes give no acceleration

using Scalar = Eigen::Matrix<double, 1, 1>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Chain = std::vector<const KeyFrame*>;

// Returns the chains of keyframes connected by IMU readings.
std::vector<Chain> Chains(const Map& map) {
  std::vector<Chain> chains;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const KeyFrame* keyframe = map.keyframe(id);
    if (!keyframe->motion) continue;
    const InertialState& motion = *keyframe->motion;
    const auto before = std::ranges::find_if(
        chains, [&](const Chain& chain) { return chain.back()->id == motion.previous; });
    if (motion.from_previous != nullptr && before != chains.end()) {
      before->push_back(keyframe);
    } else {
      chains.push_back({keyframe});
    }
  }
  std::erase_if(chains, [](const Chain& chain) { return chain.size() < kShortestChain; });
  return chains;
}

class Problem {
 public:
  Problem(const Pose& T_BC, const DepthScaleOptions& options)
      : options_(options), T_BC_(T_BC), T_CB_(T_BC.Inverse()), scale_(graph_.AddVariable(1.0)) {
    graph_.AddFactor(
        std::make_unique<VectorPrior<1>>(Scalar(1.0), Scalar(1.0 / options.prior_sigma)), scale_);
  }

  // Each chain has its own gravity, so that its first pose can be held whatever its tilt. Returns
  // false if readings have no information; the problem cannot be used then.
  bool Add(const Chain& chain, const Eigen::Vector3d& gravity_W) {
    const Variable<UnitDirection> gravity = graph_.AddVariable(UnitDirection(gravity_W));
    Body before = AddBody(*chain.front());
    graph_.Fix(before.pose);
    AddBiasPrior(before.bias);
    for (std::size_t i = 1; i < chain.size(); ++i) {
      const KeyFrame &from = *chain[i - 1], &to = *chain[i];
      const Body body = AddBody(to);
      const ImuBias& bias = from.motion->bias;
      const ImuPreintegration& stored = *to.motion->from_previous;
      const ImuPreintegration imu =
          stored.NeedsReintegration(bias) ? stored.Reintegrated(bias) : stored;
      if (!imu.HasInformation()) return false;
      graph_.AddFactor(std::make_unique<ImuGravityFactor>(imu), before.pose, before.velocity,
                       before.bias, body.pose, body.velocity, body.bias, gravity);
      AddMotion(from.T_WC.Inverse() * to.T_WC, before.pose, body.pose);
      before = body;
    }
    keyframes_ += static_cast<int>(chain.size());
    // Six per motion, minus the first velocity and gravity.
    degrees_of_freedom_ += 6 * (static_cast<int>(chain.size()) - 1) - 5;
    return true;
  }

  // Returns empty if the solution has no covariance.
  std::optional<DepthScale> Solve() {
    if (!graph_.Solve().IsUsable()) return std::nullopt;
    const auto covariance = graph_.Covariance(scale_);
    if (!covariance) return std::nullopt;
    DepthScale result;
    result.scale = graph_.Value(scale_);
    result.keyframes = keyframes_;
    result.error = 2.0 * graph_.Cost() / degrees_of_freedom_;
    result.sigma = std::sqrt((*covariance)(0, 0) * std::max(1.0, result.error));
    return result;
  }

 private:
  struct Body {
    Variable<Pose> pose;
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };

  Body AddBody(const KeyFrame& keyframe) {
    return {graph_.AddVariable(keyframe.T_WC * T_CB_), graph_.AddVariable(keyframe.motion->v_WB),
            graph_.AddVariable(keyframe.motion->bias)};
  }

  // Around zero: the odometry estimated the biases with the uncorrected scale.
  void AddBiasPrior(const Variable<ImuBias>& bias) {
    Vector6 sigma;
    sigma << Eigen::Vector3d::Constant(options_.gyroscope_bias_sigma),
        Eigen::Vector3d::Constant(options_.accelerometer_bias_sigma);
    graph_.AddFactor(
        std::make_unique<VectorPrior<6>>(ImuBias::Zero(), sigma.cwiseInverse().asDiagonal()), bias);
  }

  void AddMotion(const Pose& T_CiCj, const Variable<Pose>& from, const Variable<Pose>& to) {
    Vector6 sigma;
    sigma << Eigen::Vector3d::Constant(options_.position_sigma +
                                       options_.position_share * T_CiCj.p().norm()),
        Eigen::Vector3d::Constant(options_.rotation_sigma);
    graph_.AddFactor(
        std::make_unique<ScaledMotion>(T_CiCj, sigma.cwiseInverse().asDiagonal(), T_BC_), from, to,
        scale_);
  }

  const DepthScaleOptions& options_;
  const Pose T_BC_, T_CB_;
  FactorGraph graph_;
  const Variable<double> scale_;
  int keyframes_ = 0, degrees_of_freedom_ = 0;
};

}  // namespace

void DepthScaleOptions::Validate() const {
  const auto require = [](bool valid, const char* field) {
    HIGHWALL_REQUIRE(valid, std::string("DepthScaleOptions::") + field + " must be positive");
  };
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  require(positive(prior_sigma), "prior_sigma");
  require(positive(position_sigma), "position_sigma");
  require(position_share == 0.0 || positive(position_share), "position_share");
  require(positive(rotation_sigma), "rotation_sigma");
  require(positive(gyroscope_bias_sigma), "gyroscope_bias_sigma");
  require(positive(accelerometer_bias_sigma), "accelerometer_bias_sigma");
}

Map AdjustedWithoutImu(const Map& map, const MeasurementModel& model,
                       const BundleAdjustmentOptions& options) {
  Map images = map.Clone();
  for (const SubmapId root : images.roots()) {
    images.SetGravity(std::nullopt, root);
    AdjustBundle(images, model, images.KeyFramesOf(root), {}, options);
    images.SetGravity(map.gravity_W(root), root);
  }
  return images;
}

std::optional<DepthScale> EstimateDepthScale(const Map& map, const Pose& T_BC,
                                             const DepthScaleOptions& options) {
  options.Validate();
  std::vector<Chain> chains = Chains(map);
  const auto gravity_W = [&](const Chain& chain) { return map.gravity_W(chain.front()->submap); };
  std::erase_if(chains, [&](const Chain& chain) { return !gravity_W(chain); });
  if (chains.empty()) return std::nullopt;
  Problem problem(T_BC, options);
  for (const Chain& chain : chains) {
    if (!problem.Add(chain, *gravity_W(chain))) return std::nullopt;
  }
  return problem.Solve();
}

}  // namespace highwall
