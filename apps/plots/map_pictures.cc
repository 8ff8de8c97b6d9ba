#include "plots/map_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/mapping/map_comparison.h>

#include "images/encode.h"
#include "plots/colour_map.h"

namespace highwall::apps {
namespace {

constexpr int kMargin = 8;  // [px]
const cv::Scalar kBackground(255, 255, 255), kPath(40, 40, 230);

// Rows: right, down and depth of the picture, as directions of G.
Eigen::Matrix3d ViewRotation(MapView view) {
  Eigen::Matrix3d R_VG;
  if (view == MapView::kTop) {
    R_VG << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    return R_VG;
  }
  const double pan = 30.0 * std::numbers::pi / 180.0, tilt = 40.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d right(std::cos(pan), std::sin(pan), 0.0);
  const Eigen::Vector3d away(-std::sin(pan) * std::cos(tilt), std::cos(pan) * std::cos(tilt),
                             -std::sin(tilt));
  R_VG.row(0) = right;
  R_VG.row(1) = away.cross(right);
  R_VG.row(2) = away;
  return R_VG;
}

// Picture that contains all given points: pixels are right and down in V, its third axis is depth.
class Canvas {
 public:
  Canvas(const Eigen::Matrix3d& R_VW, const std::vector<Eigen::Vector3f>& points_W, int size)
      : R_VW_(R_VW) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3f& p : points_W) {
      box.extend((R_VW_ * p.cast<double>()).head<2>());
    }
    const double extent = std::max(box.sizes().maxCoeff(), 1e-3);
    scale_ = (size - 2 * kMargin) / extent;
    corner_ = box.min();
    const Eigen::Vector2i pixels = (scale_ * box.sizes()).array().ceil().cast<int>();
    image_ = cv::Mat(pixels.y() + 2 * kMargin, pixels.x() + 2 * kMargin, CV_8UC3, kBackground);
  }

  Eigen::Vector3d Project(const Eigen::Vector3d& p_W) const {
    Eigen::Vector3d p_V = R_VW_ * p_W;
    p_V.head<2>() = scale_ * (p_V.head<2>() - corner_) + Eigen::Vector2d::Constant(kMargin);
    return p_V;
  }
  void DrawPath(const Trajectory& trajectory) {
    std::vector<cv::Point> path;
    for (const StampedPose& pose : trajectory) {
      const Eigen::Vector2i uv = Project(pose.pose.p()).head<2>().array().round().cast<int>();
      path.emplace_back(uv.x(), uv.y());
    }
    if (path.size() < 2) return;
    // White edges make it visible on every background.
    cv::polylines(image_, path, false, kBackground, 5, cv::LINE_AA);
    cv::polylines(image_, path, false, kPath, 2, cv::LINE_AA);
  }
  cv::Mat& image() { return image_; }
  double scale() const { return scale_; }  // [px/m]

 private:
  Eigen::Matrix3d R_VW_;
  double scale_ = 1.0;
  Eigen::Vector2d corner_;
  cv::Mat image_;
};

// Returns the points to show, including the camera path.
std::vector<Eigen::Vector3f> WithPath(std::vector<Eigen::Vector3f> points,
                                      const Trajectory& trajectory) {
  for (const StampedPose& pose : trajectory) points.push_back(pose.pose.p().cast<float>());
  return points;
}

struct Face {
  std::array<Eigen::Vector3d, 4> corners_W;
  double shade = 1.0;
};

// Returns the faces of a cube that are visible; away_W: viewing direction.
std::vector<Face> VisibleFaces(const Eigen::Vector3d& center, double size,
                               const Eigen::Vector3d& away_W) {
  constexpr std::array<double, 3> kShades = {0.7, 0.85, 1.0};
  std::vector<Face> faces;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(away_W[axis]) < 1e-6) continue;
    const Eigen::Vector3d n = Eigen::Vector3d::Unit(axis) * (away_W[axis] > 0.0 ? -1.0 : 1.0);
    const Eigen::Vector3d s = Eigen::Vector3d::Unit((axis + 1) % 3);
    const Eigen::Vector3d t = Eigen::Vector3d::Unit((axis + 2) % 3);
    Face& face = faces.emplace_back();
    face.shade = kShades[static_cast<std::size_t>(axis)];
    const double half = 0.5 * size;
    face.corners_W = {center + half * (n + s + t), center + half * (n + s - t),
                      center + half * (n - s - t), center + half * (n - s + t)};
  }
  return faces;
}

}  // namespace

cv::Mat DrawCloud(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size) {
  if (dense.cloud.empty()) return {};
  std::vector<Eigen::Vector3f> points;
  for (const ColoredPoint& point : dense.cloud) points.push_back(point.p);
  Canvas canvas(ViewRotation(view) * dense.R_GW.toRotationMatrix(), WithPath(points, trajectory),
                size);
  cv::Mat nearest(canvas.image().size(), CV_64FC1, cv::Scalar(1e300));
  const int splat = std::clamp(static_cast<int>(std::lround(0.01 * canvas.scale())) + 1, 2, 8);
  for (const ColoredPoint& point : dense.cloud) {
    const Eigen::Vector3d p = canvas.Project(point.p.cast<double>());
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    for (int dv = 0; dv < splat; ++dv) {
      for (int du = 0; du < splat; ++du) {
        if (u + du >= nearest.cols || v + dv >= nearest.rows) continue;
        double& depth = nearest.at<double>(v + dv, u + du);
        if (p.z() >= depth) continue;
        depth = p.z();
        canvas.image().at<cv::Vec3b>(v + dv, u + du) = {point.rgb[2], point.rgb[1], point.rgb[0]};
      }
    }
  }
  canvas.DrawPath(trajectory);
  return canvas.image();
}

cv::Mat DrawOctree(const DenseMap& dense, const Trajectory& trajectory, MapView view, int size) {
  std::vector<OctreeLeaf> leaves;
  std::vector<Eigen::Vector3f> points;
  dense.octree.ForEachLeaf([&](const OctreeLeaf& leaf) {
    if (!leaf.occupied) return;
    leaves.push_back(leaf);
    points.push_back(leaf.center_W.cast<float>());
  });
  if (leaves.empty()) return {};
  const Eigen::Matrix3d R_GW = dense.R_GW.toRotationMatrix();
  const Eigen::Matrix3d R_VW = ViewRotation(view) * R_GW;
  Canvas canvas(R_VW, WithPath(points, trajectory), size);
  std::vector<double> heights;
  for (const OctreeLeaf& leaf : leaves) heights.push_back((R_GW * leaf.center_W).z());
  std::ranges::sort(heights);
  // Clips two percent of the heights, so that outlier voxels do not dominate the colour range.
  const double low = heights[heights.size() / 100];
  const double high = heights[heights.size() - 1 - heights.size() / 100];
  const auto depth = [&](const OctreeLeaf& leaf) { return (R_VW * leaf.center_W).z(); };
  std::ranges::sort(leaves, std::ranges::greater(), depth);
  for (const OctreeLeaf& leaf : leaves) {
    const double height = ((R_GW * leaf.center_W).z() - low) / std::max(high - low, 1e-6);
    const auto [r, g, b] = Viridis(height);
    for (const Face& face : VisibleFaces(leaf.center_W, leaf.size, R_VW.row(2))) {
      std::array<cv::Point, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector3d p = canvas.Project(face.corners_W[i]);
        corners[i] = {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
      }
      cv::fillConvexPoly(canvas.image(), corners.data(), 4, face.shade * cv::Scalar(b, g, r));
    }
  }
  canvas.DrawPath(trajectory);
  return canvas.image();
}

cv::Mat HeightImage(const HeightMap& heights) {
  cv::Mat image = cv::Mat::zeros(heights.height, heights.width, CV_16UC1);
  float low = std::numeric_limits<float>::infinity();
  for (const float z : heights.z) low = std::fmin(low, z);
  for (int j = 0; j < heights.height; ++j) {
    for (int i = 0; i < heights.width; ++i) {
      const float z = heights.At(i, j);
      if (std::isnan(z)) continue;
      image.at<std::uint16_t>(heights.height - 1 - j, i) =
          cv::saturate_cast<std::uint16_t>(1.0f + 1000.0f * (z - low));
    }
  }
  return image;
}

void WritePng(const std::filesystem::path& path, const cv::Mat& image) {
  const std::vector<std::uint8_t> bytes = EncodePng(image);
  AtomicFile file(path);
  file.stream().write(reinterpret_cast<const char*>(bytes.data()),
                      static_cast<std::streamsize>(bytes.size()));
  file.Commit();
}

void WriteMapPicture(const std::filesystem::path& path, const MapPicture& picture,
                     const DenseMap& dense, const Trajectory& trajectory) {
  constexpr int kSize = 1200;  // [px]
  const cv::Mat image = picture.draw(dense, trajectory, picture.view, kSize);
  if (!image.empty()) WritePng(path, image);
}

}  // namespace highwall::apps
