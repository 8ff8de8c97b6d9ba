#pragma once

#include <memory>
#include <vector>

#include <ceres/cost_function.h>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// A MapFactor as a factor on the poses of the keyframes to which its bodies are anchored.
//
//   T_WB = T_WX T_XB, per body, with T_XB as anchored
//
// Blocks: T_WX (7, PoseManifold) of each of keyframes(), then the remaining blocks of the cost
// unchanged. Two bodies anchored to one keyframe share its block.
class AnchoredCost final : public ceres::CostFunction {
 public:
  // T_XC: camera pose of a keyframe in the frame X whose poses are the variables: the body in a
  // bundle adjustment, the camera itself in a pose graph.
  AnchoredCost(const MapFactor& factor, const Pose& T_XC);

  // One per block.
  const std::vector<KeyFrameId>& keyframes() const { return keyframes_; }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  struct Body {
    std::size_t block = 0;  // of its keyframe
    Pose T_XB;
  };

  // Adds the Jacobian of a body's pose (ambient, as from the cost) to that of its keyframe's pose.
  void Chain(const Body& body, const double* T_WX, const double* T_WB, const double* of_body,
             double* of_keyframe) const;

  const std::shared_ptr<const ceres::CostFunction> cost_;
  std::vector<Body> bodies_;
  std::vector<KeyFrameId> keyframes_;
};

// Returns the factors that constrain a world: all bodies are anchored to keyframes of it, and the
// pose of their frame in it is known. A single pose without a frame belongs to the first submap's
// world.
std::vector<const MapFactor*> FactorsIn(const Map& map, SubmapId submap);

// Returns the standard deviation [rad] between up and the z axis of a world if gravity is known;
// otherwise that of a hand-held camera, by which W was aligned.
double UprightSigma(const Map& map, SubmapId submap);

}  // namespace highwall
