#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/sliding_window_smoother.h>

#include <memory>

#include "fuzz.h"

namespace highwall::fuzz {
namespace {

SlidingWindowSmoother TwoPoses() {
  const Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Identity();
  const Pose step = Pose::FromTangent({1, 0, 0}, {0, 0, 0.5});
  SlidingWindowSmoother smoother;
  const Variable<Pose> a = smoother.AddState(1'000, Pose());
  const Variable<Pose> b = smoother.AddState(2'000, step);
  const Variable<Eigen::Vector3d> v =
      smoother.AddCalibration(Eigen::Vector3d(Eigen::Vector3d::Ones()));
  smoother.AddFactor(std::make_unique<PosePrior>(Pose(), W), a);
  smoother.AddFactor(std::make_unique<RelativePose>(step, W), a, b);
  smoother.AddFactor(
      std::make_unique<VectorPrior<3>>(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()), v);
  smoother.Update();
  return smoother;
}

}  // namespace

const Target kTarget{
    .file_name = "smoother.txt",
    .seeds =
        [] {
          return std::vector<std::string>{
              Written([](const auto& path) { TwoPoses().Save(path); }),
              Written([](const auto& path) { SlidingWindowSmoother().Save(path); })};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          auto smoother = SlidingWindowSmoother::Load<Pose, Eigen::Vector3d>(path);
          smoother.Update();
        },
};

}  // namespace highwall::fuzz
