#pragma once

#include <memory>
#include <vector>

#include <ceres/cost_function.h>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// A MapFactor as a factor on the poses of the keyframes that carry its bodies.
//
//   T_WB = T_WX T_XB, per body, with T_XB as it is carried
//
// Blocks: T_WX (7, PoseManifold) of each of keyframes(), then those of the cost beyond its bodies
// as they are. Two bodies that hang on one keyframe share its block.
class CarriedCost final : public ceres::CostFunction {
 public:
  // T_XC: of the camera of a keyframe, in the frame X whose poses are the variables: the body in an
  // adjustment, the camera itself in a pose graph.
  CarriedCost(const MapFactor& factor, const Pose& T_XC);

  // By block.
  const std::vector<KeyFrameId>& keyframes() const { return keyframes_; }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  struct Body {
    std::size_t block = 0;  // of its keyframe
    Pose T_XB;
  };

  // Adds the Jacobian of a body's pose (ambient, as the cost gives it) to that of its keyframe's.
  void Chain(const Body& body, const double* T_WX, const double* T_WB, const double* of_body,
             double* of_keyframe) const;

  const std::shared_ptr<const ceres::CostFunction> cost_;
  std::vector<Body> bodies_;
  std::vector<KeyFrameId> keyframes_;
};

// The factors that tell something in a world: all bodies hang on keyframes of it, and where their
// frame lies in it is known. A single pose in no frame is one of the first submap's world.
std::vector<const MapFactor*> FactorsIn(const Map& map, SubmapId submap);

// [rad] How far from its z axis up is in a world, where gravity is known; where it is not, W is as
// level as somebody holds a camera.
double UprightSigma(const Map& map, SubmapId submap);

}  // namespace highwall
