#include "input/lens_reach.h"

#include <algorithm>

namespace highwall {

double SquaredReach(const PinholeCamera& camera) {
  constexpr int kSteps = 8;  // along each side
  const double right = camera.width - 1.0, bottom = camera.height - 1.0;
  double reach = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = right * i / kSteps, v = bottom * i / kSteps;
    for (const Eigen::Vector2d& uv :
         {Eigen::Vector2d(u, 0.0), {u, bottom}, {0.0, v}, {right, v}}) {
      reach = std::max(reach, camera.Unproject(uv, 1.0).head<2>().squaredNorm());
    }
  }
  return reach;
}

}  // namespace highwall
