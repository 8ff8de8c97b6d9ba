#include <highwall/frontend/features/frame.h>

#include <cmath>
#include <numbers>

namespace highwall {

float LineSegment::Length() const {
  return (e - s).norm();
}

float LineSegment::Angle() const {
  constexpr float kHalfTurn = std::numbers::pi_v<float>;
  const float angle = std::atan2(e.y() - s.y(), e.x() - s.x());
  const float wrapped = angle < 0.0F ? angle + kHalfTurn : angle;
  return wrapped < kHalfTurn ? wrapped : 0.0F;
}

Eigen::Vector2f LineSegment::Midpoint() const {
  return 0.5F * (s + e);
}

}  // namespace highwall
