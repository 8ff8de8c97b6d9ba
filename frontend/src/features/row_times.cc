#include "features/row_times.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>
#include <highwall/internal/target_clones.h>

#include "features/feature_kinds.h"

namespace highwall {
namespace {

constexpr double kFar = 100.0;  // [m] distance at which the motion of the camera is not visible

// std::floor, whose call would keep the loop over a row from being vectorized.
inline int Floor(float x) {
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

// `value` if `holds`, else 0. A conditional expression would keep a loop from being vectorized,
// because its quotients could no longer be computed for all pixels.
inline float OrZero(bool holds, float value) {
  const std::uint32_t mask = 0U - static_cast<std::uint32_t>(holds);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & mask);
}

// A depth image [m] and its camera, in plain numbers.
struct DepthReadings {
  const float* depth;
  unsigned stride, width, height;  // [px]
  const float* x;                  // of each column, on the plane z = 1
  float mean;                      // [1/m] inverse depth where there is no reading
  float fx, fy, cx, cy;            // [px]
};

// Motion of the camera [m], [rad], in plain numbers.
struct SmallMotion {
  float rho_x, rho_y, rho_z, theta_x, theta_y, theta_z;
};

// Fills a row with the readings at the pixels where its own appear after the motion, as they were
// before it; 0 where there is none. y: of the row, on the plane z = 1. Free of branches, so that it
// compiles to vector instructions (AVX2 without FMA: both clones round identically).
HIGHWALL_TARGET_CLONES("avx2", "default")
void ReadEarlierRow(const DepthReadings& readings, unsigned v, float y, const SmallMotion& motion,
                    float* __restrict filled) {
  const auto [depth, stride, width, height, columns_x, mean, fx, fy, cx, cy] = readings;
  const auto [rho_x, rho_y, rho_z, theta_x, theta_y, theta_z] = motion;
  const float* const row = depth + std::size_t{v} * stride;
  const float middle = static_cast<float>(v) + 0.5F;
  const auto count = static_cast<int>(width);
  for (int u = 0; u < count; ++u) {
    const float x = columns_x[u];
    const bool measured = row[u] > 0.0F;
    const float inverse = OrZero(measured, 1.0F / row[u]) + OrZero(!measured, mean);
    const float turn = theta_x * y - theta_y * x;
    const float dx = (rho_x - x * rho_z) * inverse + theta_y - theta_z * y - x * turn;
    const float dy = (rho_y - y * rho_z) * inverse + theta_z * x - theta_x - y * turn;
    const int column = Floor(static_cast<float>(u) + 0.5F - fx * dx);
    const int line = Floor(middle - fy * dy);
    const auto at_column = static_cast<unsigned>(column), at_line = static_cast<unsigned>(line);
    const bool inside = (at_column < width) & (at_line < height);  // not below 0 either
    const auto place =
        static_cast<int>((at_line * stride + at_column) * static_cast<unsigned>(inside));
    const float z = depth[place];
    const float read_x = (static_cast<float>(column) - cx) / fx;
    const float read_y = (static_cast<float>(line) - cy) / fy;
    const float before = z + rho_z + z * (theta_x * read_y - theta_y * read_x);
    filled[u] = OrZero(inside & (z > 0.0F) & (before > 0.0F), before);
  }
}

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

// Camera and motion in the image mirrored at its diagonal, where x and y have changed places. An
// angular velocity is an axial vector, which a mirror also reverses.
PinholeCamera Transposed(PinholeCamera camera) {
  std::swap(camera.width, camera.height);
  std::swap(camera.fx, camera.fy);
  std::swap(camera.cx, camera.cy);
  return camera;
}

Twist Transposed(const Twist& motion) {
  const Eigen::Vector3d &v = motion.v, &omega = motion.omega;
  return {.v = {v.y(), v.x(), v.z()}, .omega = {-omega.y(), -omega.x(), -omega.z()}};
}

// DepthAtTime() of an image that is read row by row, downwards or upwards.
cv::Mat EarlierByRows(const cv::Mat& depth, const PinholeCamera& camera, const Twist& motion,
                      double delay, double readout, bool upwards) {
  cv::Mat earlier(depth.size(), CV_32FC1);
  std::vector<float> columns_x;
  for (int u = 0; u < depth.cols; ++u) {
    columns_x.push_back(static_cast<float>((u - camera.cx) / camera.fx));
  }
  const DepthReadings readings{.depth = depth.ptr<float>(),
                               .stride = static_cast<unsigned>(depth.step1()),
                               .width = static_cast<unsigned>(depth.cols),
                               .height = static_cast<unsigned>(depth.rows),
                               .x = columns_x.data(),
                               .mean = MeanInverseDepth(depth),
                               .fx = static_cast<float>(camera.fx),
                               .fy = static_cast<float>(camera.fy),
                               .cx = static_cast<float>(camera.cx),
                               .cy = static_cast<float>(camera.cy)};
  for (int v = 0; v < depth.rows; ++v) {
    const double late = delay + RowTime(upwards ? depth.rows - 1 - v : v, depth.rows) * readout;
    const Eigen::Vector3f rho = (late * motion.v).cast<float>();
    const Eigen::Vector3f theta = (late * motion.omega).cast<float>();
    ReadEarlierRow(
        readings, static_cast<unsigned>(v), static_cast<float>((v - camera.cy) / camera.fy),
        {rho.x(), rho.y(), rho.z(), theta.x(), theta.y(), theta.z()}, earlier.ptr<float>(v));
  }
  return earlier;
}

}  // namespace

cv::Mat DepthAtTime(const cv::Mat& depth, const PinholeCamera& camera, const Twist& motion,
                    double delay, double readout, ReadoutDirection direction) {
  HIGHWALL_REQUIRE(
      depth.type() == CV_32FC1 && depth.cols == camera.width && depth.rows == camera.height,
      "DepthAtTime: the depth image must be CV_32FC1 of the camera's size");
  const bool back = direction == ReadoutDirection::kUp || direction == ReadoutDirection::kLeft;
  if (direction == ReadoutDirection::kDown || direction == ReadoutDirection::kUp) {
    return EarlierByRows(depth, camera, motion, delay, readout, back);
  }
  return EarlierByRows(depth.t(), Transposed(camera), Transposed(motion), delay, readout, back).t();
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
                                                            double readout, const Twist& motion,
                                                            ReadoutDirection direction) {
  return Moved(features, camera, [&](const Eigen::Vector2d& uv, const Eigen::Vector3d& p_C, bool) {
    return motion.Transform(readout * RowTime(uv, camera, direction), p_C);
  });
}

bool Differ(const RowMotion& a, const RowMotion& b, const PinholeCamera& camera, double depth) {
  constexpr double kShows = 0.1;  // [px] visible difference
  const auto shift = [&](double late_a, double late_b) {
    return camera.fx * ((late_b * b.motion.omega - late_a * a.motion.omega).norm() +
                        (late_b * b.motion.v - late_a * a.motion.v).norm() / depth);
  };
  return shift(0.5 * a.timing.colour_readout, 0.5 * b.timing.colour_readout) > kShows ||
         shift(a.DepthLate(-0.5), b.DepthLate(-0.5)) > kShows ||
         shift(a.DepthLate(0.5), b.DepthLate(0.5)) > kShows;
}

double MedianDepth(const FrameFeatures& features) {
  std::vector<double> depths;
  depths.reserve(features.points.size());
  for (const PointFeature& point : features.points) {
    if (point.depth > 0.0) depths.push_back(point.depth);
  }
  return depths.empty() ? std::numeric_limits<double>::infinity() : UpperMedian(std::move(depths));
}

std::shared_ptr<const FrameFeatures> MovedOtherwise(const FrameFeatures& features,
                                                    const PinholeCamera& camera,
                                                    const DepthGrid& grid, const RowMotion& assumed,
                                                    const RowMotion& found) {
  const ReadoutDirection direction = found.timing.direction;
  return Moved(
      features, camera, [&](const Eigen::Vector2d& uv, const Eigen::Vector3d& p_C, bool measured) {
        const double row_time = RowTime(uv, camera, direction);
        Eigen::Vector3d seen =
            assumed.motion.Transform(-assumed.timing.colour_readout * row_time, p_C);
        if (measured) {
          const double before = assumed.DepthLate(row_time), after = found.DepthLate(row_time);
          // The rate is linear in the motion. At an edge the surface is assumed to face the camera.
          const Twist more{after * found.motion.v - before * assumed.motion.v,
                           after * found.motion.omega - before * assumed.motion.omega};
          const double change =
              DepthRate(features.depth_grid, grid, p_C, more).value_or(more.Flow(p_C).z());
          seen *= std::max(0.5, 1.0 - change / seen.z());
        }
        return found.motion.Transform(found.timing.colour_readout * row_time, seen);
      });
}

}  // namespace highwall
