// Runs the program of docs/tutorial_inertial.md over a second at rest; exits 0 if it stays there.
#include <inertial/inertial_trajectory.h>

int main() {
  using namespace highwall;
  const PinholeCamera camera;
  InertialTrajectory trajectory(camera, Pose(), ImuNoise(), ImuState{});
  const std::vector<Feature> features = {
      {0, {100, 100}, 2.0}, {1, {500, 120}, 3.0}, {2, {320, 400}, 2.5}, {3, {150, 300}, 4.0}};
  constexpr Stamp kMillisecond = 1'000'000;
  std::optional<Pose> T_WB;
  for (Stamp t = 0; t <= 1010; t += 5) {
    trajectory.AddReading(
        {t * kMillisecond, Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, kStandardGravity)});
    // An image waits for the reading after it.
    if (t % 100 == 5) T_WB = trajectory.AddImage((t - 5) * kMillisecond, features);
    if (t % 100 == 5 && !T_WB) return 1;
  }
  return T_WB->p().norm() < 1e-6 && trajectory.state().v_WB.norm() < 1e-6 ? 0 : 1;
}
