#include "map/yaw_and_shift.h"

#include <Eigen/Geometry>

namespace highwall {

Pose YawAndShift(const Pose& T, const Eigen::Vector3d& p) {
  const Eigen::Quaterniond q = T.q();
  const Eigen::Quaterniond yaw = q.w() == 0.0 && q.z() == 0.0
                                     ? Eigen::Quaterniond::Identity()
                                     : Eigen::Quaterniond(q.w(), 0.0, 0.0, q.z()).normalized();
  return Pose(yaw, T * p - yaw * p);
}

}  // namespace highwall
