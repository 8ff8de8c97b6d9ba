#include <memory>
#include <vector>

#include <highwall/factors/imu_factor.h>
#include <highwall/factors/zero_velocity.h>

#include "evaluate_bench.h"
#include "support/imu_scene.h"
#include "support/imu_twins.h"

namespace highwall::imu_factor_bench {
namespace {

const bool registered = [] {
  const SinusoidalMotion motion;
  const ImuPreintegration imu(motion.Samples(200.0, 0.2), ImuBias::Zero());
  std::vector<std::vector<double>> blocks;
  for (const double t : {0.0, 0.2}) {
    const ImuState state = motion.StateAt(t);
    blocks.emplace_back(state.T_WB.data(), state.T_WB.data() + Pose::kSize);
    blocks.emplace_back(state.v_WB.data(), state.v_WB.data() + 3);
    blocks.push_back({0.01, -0.01, 0.02, 0.1, 0.05, -0.1});
  }
  RegisterEvaluate("ImuFactor", std::make_shared<ImuFactor>(imu, kGravity),
                   MakeImu(twins::Imu(imu)), blocks);
  blocks.push_back({0.0, 0.0, -1.0});
  RegisterEvaluate("ImuGravityFactor", std::make_shared<ImuGravityFactor>(imu),
                   MakeImuGravity(twins::Imu(imu)), blocks);
  RegisterEvaluate("ZeroVelocity", std::make_shared<ZeroVelocity>(0.01),
                   twins::MakeZeroVelocity(0.01), {{0.1, 0.2, 0.3}});
  return true;
}();

}  // namespace
}  // namespace highwall::imu_factor_bench
