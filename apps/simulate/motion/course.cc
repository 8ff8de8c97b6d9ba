#include "simulate/motion/course.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::simulate {
namespace {

constexpr int kStepsPerPoint = 64;

}  // namespace

Course::Course(std::vector<Eigen::Vector3d> control) : control_(std::move(control)) {
  HIGHWALL_REQUIRE(control_.size() >= 4, "Course: needs at least 4 control points");
  Eigen::Vector3d last, point, derivative;
  Evaluate(0.0, &last, &derivative);
  lengths_.push_back(0.0);
  for (std::size_t i = 1; i <= kStepsPerPoint * control_.size(); ++i) {
    Evaluate(static_cast<double>(i) / kStepsPerPoint, &point, &derivative);
    lengths_.push_back(lengths_.back() + (point - last).head<2>().norm());
    last = point;
  }
}

void Course::Evaluate(double u, Eigen::Vector3d* point, Eigen::Vector3d* derivative) const {
  const std::size_t n = control_.size();
  const auto i = static_cast<std::size_t>(u);
  const double w = u - static_cast<double>(i), v = 1.0 - w;
  const Eigen::Vector3d &a = control_[i % n], &b = control_[(i + 1) % n],
                        &c = control_[(i + 2) % n], &d = control_[(i + 3) % n];
  *point = (v * v * v * a + (4 - 6 * w * w + 3 * w * w * w) * b +
            (4 - 6 * v * v + 3 * v * v * v) * c + w * w * w * d) /
           6;
  *derivative = (v * v * (b - a) + (1 + 2 * w * v) * (c - b) + w * w * (d - c)) / 2;
}

Course::Frame Course::At(double s) const {
  const double within = s - std::floor(s / length()) * length();
  const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, within);
  const double step = (within - *(next - 1)) / (*next - *(next - 1));
  const double u = (static_cast<double>(next - 1 - lengths_.begin()) + step) / kStepsPerPoint;
  Eigen::Vector3d point, derivative;
  Evaluate(u, &point, &derivative);
  const Eigen::Vector3d forward = Eigen::Vector3d(derivative.x(), derivative.y(), 0).normalized();
  return {point, forward, {-forward.y(), forward.x(), 0}};
}

}  // namespace highwall::simulate
