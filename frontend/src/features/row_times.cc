#include "features/row_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>

#include "features/feature_kinds.h"

namespace highwall {
namespace {

constexpr double kFar = 100.0;  // [m] distance at which the motion of the camera is not visible

// std::floor, whose call would keep the loop over a row from being vectorized.
int Floor(float x) {
  const auto towards_zero = static_cast<int>(x);
  return towards_zero - (x < static_cast<float>(towards_zero) ? 1 : 0);
}

// Mean inverse depth [1/m] over a sample of the readings; that of a distant point if there are
// none.
float MeanInverseDepth(const cv::Mat& depth) {
  constexpr int kStep = 16;
  double sum = 0.0;
  int count = 0;
  for (int v = 0; v < depth.rows; v += kStep) {
    const float* row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; u += kStep) {
      if (!(row[u] > 0.0F)) continue;
      sum += 1.0 / static_cast<double>(row[u]);
      ++count;
    }
  }
  return static_cast<float>(count > 0 ? sum / count : 1.0 / kFar);
}

double MeanDepth(const FrameFeatures& features) {
  double sum = 0.0;
  int count = 0;
  for (const PointFeature& point : features.points) {
    if (!(point.depth > 0.0)) continue;
    sum += 1.0 / point.depth;
    ++count;
  }
  return count > 0 ? count / sum : kFar;
}

// One row of DepthAtTime: where its pixels appear slightly later, and the readings there.
class LaterRow {
 public:
  LaterRow(const cv::Mat& depth, const PinholeCamera& camera)
      : depth_(depth),
        camera_(camera),
        mean_(MeanInverseDepth(depth)),
        x_(static_cast<std::size_t>(depth.cols)),
        columns_(x_.size()),
        rows_(x_.size()) {
    for (int u = 0; u < depth.cols; ++u) {
      x_[static_cast<std::size_t>(u)] = static_cast<float>((u - camera.cx) / camera.fx);
    }
  }

  // rho, theta: the motion within the time by which row v is late.
  void Fill(int v, const Eigen::Vector3f& rho, const Eigen::Vector3f& theta, cv::Mat* out) {
    FindPixels(v, rho, theta);
    const auto cx = static_cast<float>(camera_.cx), cy = static_cast<float>(camera_.cy);
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    float* filled = out->ptr<float>(v);
    for (std::size_t u = 0; u < x_.size(); ++u) {
      filled[u] = 0.0F;
      if (!Contains(columns_[u], rows_[u])) continue;
      const float z = depth_.ptr<float>(rows_[u])[columns_[u]];
      if (!(z > 0.0F)) continue;
      const float x = (static_cast<float>(columns_[u]) - cx) / fx;
      const float y = (static_cast<float>(rows_[u]) - cy) / fy;
      filled[u] = std::max(0.0F, z + rho.z() + z * (theta.x() * y - theta.y() * x));
    }
  }

 private:
  bool Contains(int u, int v) const {
    return u >= 0 && v >= 0 && u < depth_.cols && v < depth_.rows;
  }

  void FindPixels(int v, const Eigen::Vector3f& rho, const Eigen::Vector3f& theta) {
    // Plain arrays and constants, and a quotient that is computed even if it is not used, allow the
    // loop to be vectorized.
    const float* row = depth_.ptr<float>(v);
    const float* columns_x = x_.data();
    int* columns = columns_.data();
    int* rows = rows_.data();
    const auto width = static_cast<int>(x_.size());
    const auto y = static_cast<float>((v - camera_.cy) / camera_.fy);
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const auto middle = static_cast<float>(v) + 0.5F;
    const float mean = mean_, rho_x = rho.x(), rho_y = rho.y(), rho_z = rho.z();
    const float theta_x = theta.x(), theta_y = theta.y(), theta_z = theta.z();
    for (int u = 0; u < width; ++u) {
      const float x = columns_x[u];
      const float quotient = 1.0F / row[u];
      const float inverse = row[u] > 0.0F ? quotient : mean;
      const float turn = theta_x * y - theta_y * x;
      const float dx = (rho_x - x * rho_z) * inverse + theta_y - theta_z * y - x * turn;
      const float dy = (rho_y - y * rho_z) * inverse + theta_z * x - theta_x - y * turn;
      columns[u] = Floor(static_cast<float>(u) + 0.5F - fx * dx);
      rows[u] = Floor(middle - fy * dy);
    }
  }

  const cv::Mat& depth_;
  const PinholeCamera& camera_;
  float mean_;            // [1/m]
  std::vector<float> x_;  // of each column, on the plane z = 1
  std::vector<int> columns_, rows_;
};

// Returns the features with all of their points moved.
std::shared_ptr<const FrameFeatures> Moved(const FrameFeatures& features,
                                           const PinholeCamera& camera, const MovePoint& move) {
  auto moved = std::make_shared<FrameFeatures>(features);
  const double mean = MeanDepth(features);
  ForEachKindOfFeature(
      [&](auto& list) {
        for (auto& feature : list) MoveFeature(move, camera, mean, &feature);
      },
      *moved);
  moved->point_grid = GridOf(moved->points, {camera.width, camera.height});
  return moved;
}

}  // namespace

cv::Mat DepthAtTime(const cv::Mat& depth, const PinholeCamera& camera, const Twist& motion,
                    double delay, double readout) {
  HIGHWALL_REQUIRE(
      depth.type() == CV_32FC1 && depth.cols == camera.width && depth.rows == camera.height,
      "DepthAtTime: the depth image must be CV_32FC1 of the camera's size");
  cv::Mat earlier(depth.size(), CV_32FC1);
  LaterRow row(depth, camera);
  for (int v = 0; v < depth.rows; ++v) {
    const double late = delay + RowTime(v, depth.rows) * readout;
    row.Fill(v, (late * motion.v).cast<float>(), (late * motion.omega).cast<float>(), &earlier);
  }
  return earlier;
}

std::optional<double> DepthRate(const cv::Mat& depth_grid, const DepthGrid& grid,
                                const Eigen::Vector3d& p_C, const Twist& motion) {
  constexpr double kSmooth = 0.05;  // of the depth: a larger step between cells is an edge
  const PinholeCamera& cells = grid.camera();
  const Eigen::Vector2d uv = cells.Project(p_C);
  const cv::Point cell(static_cast<int>(std::lround(uv.x())),
                       static_cast<int>(std::lround(uv.y())));
  const cv::Rect inner(1, 1, depth_grid.cols - 2, depth_grid.rows - 2);
  if (!inner.contains(cell)) return std::nullopt;
  const auto at = [&](int du, int dv) {
    return static_cast<double>(depth_grid.at<float>(cell.y + dv, cell.x + du));
  };
  const std::array<double, 4> around{at(-1, 0), at(1, 0), at(0, -1), at(0, 1)};
  for (const double z : around) {
    if (!(std::abs(z - p_C.z()) < kSmooth * p_C.z())) return std::nullopt;
  }
  const Eigen::Vector2d slope(0.5 * (around[1] - around[0]), 0.5 * (around[3] - around[2]));
  const Eigen::Vector3d flow = motion.Flow(p_C);
  const Eigen::Vector2d shift(cells.fx * (flow.x() - p_C.x() / p_C.z() * flow.z()) / p_C.z(),
                              cells.fy * (flow.y() - p_C.y() / p_C.z() * flow.z()) / p_C.z());
  return flow.z() - slope.dot(shift);
}

std::shared_ptr<const FrameFeatures> CompensatedToMiddleRow(const FrameFeatures& features,
                                                            const PinholeCamera& camera,
                                                            double readout, const Twist& motion) {
  return Moved(features, camera, [&](double v, const Eigen::Vector3d& p_C, bool) {
    return motion.Over(readout * RowTime(v, camera.height)) * p_C;
  });
}

bool Differ(const RowMotion& a, const RowMotion& b, const PinholeCamera& camera, double depth) {
  constexpr double kShows = 0.1;  // [px] visible difference
  const auto shift = [&](double late_a, double late_b) {
    return camera.fx * ((late_b * b.motion.omega - late_a * a.motion.omega).norm() +
                        (late_b * b.motion.v - late_a * a.motion.v).norm() / depth);
  };
  return shift(0.5 * a.timing.colour_readout, 0.5 * b.timing.colour_readout) > kShows ||
         shift(a.DepthLate(0.0, 1), b.DepthLate(0.0, 1)) > kShows ||
         shift(a.DepthLate(1.0, 1), b.DepthLate(1.0, 1)) > kShows;
}

double MedianDepth(const FrameFeatures& features) {
  std::vector<double> depths;
  for (const PointFeature& point : features.points) {
    if (point.depth > 0.0) depths.push_back(point.depth);
  }
  return depths.empty() ? std::numeric_limits<double>::infinity() : UpperMedian(std::move(depths));
}

std::shared_ptr<const FrameFeatures> MovedOtherwise(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthGrid& grid, const RowMotion& assumed,
                                                    const RowMotion& found) {
  return Moved(features, camera, [&](double v, const Eigen::Vector3d& p_C, bool measured) {
    const double row_time = RowTime(v, camera.height);
    Eigen::Vector3d seen =
        assumed.motion.Over(assumed.timing.colour_readout * row_time).Inverse() * p_C;
    if (measured) {
      const double before = assumed.DepthLate(v, camera.height);
      const double after = found.DepthLate(v, camera.height);
      // The rate is linear in the motion. At an edge the surface is assumed to face the camera.
      const Twist more{after * found.motion.v - before * assumed.motion.v,
                       after * found.motion.omega - before * assumed.motion.omega};
      const double change =
          DepthRate(features.depth_grid, grid, p_C, more).value_or(more.Flow(p_C).z());
      seen *= std::max(0.5, 1.0 - change / seen.z());
    }
    return (found.motion.Over(found.timing.colour_readout * row_time) * seen).eval();
  });
}

}  // namespace highwall
