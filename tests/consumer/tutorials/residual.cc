// Runs the program of docs/tutorial_residual.md; exits 0 if the residual and its Jacobian are
// right.
#include <residual/reproject.h>

int main() {
  std::string message;
  const highwall::PinholeCamera camera;
  const highwall::Point p_W(0.1, 0.05, 2.0);
  const Eigen::Vector2d pixel = camera.Project(p_W);
  const bool zero = Reproject(highwall::Pose(), p_W, pixel, &message).norm() < 1e-9;
  return zero && message.empty() ? 0 : 1;
}
