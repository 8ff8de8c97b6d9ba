#include "plots/sparse_map_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>
#include <opencv2/imgproc.hpp>

namespace highwall::apps {
namespace {

constexpr double kPictureMargin = 0.04;  // of the size
// BGR: green, orange and blue as in the report page, distinguishable with every kind of colour
// vision.
const cv::Scalar kWhite(255, 255, 255), kInk(60, 60, 60), kPoint(40, 40, 40), kLine(94, 128, 0),
    kTrajectory(10, 80, 196), kKeyframe(178, 114, 0);
constexpr int kFraction = 4;  // fractional bits of pixel coordinates

// Picture with x to the right and y upwards.
class Sheet {
 public:
  Sheet(const Eigen::AlignedBox2d& box, int size)
      : low_(box.min()),
        margin_(kPictureMargin * size),
        scale_((size - 2.0 * margin_) / std::max(box.sizes().maxCoeff(), 1e-3)) {
    const Eigen::Vector2i pixels =
        (scale_ * box.sizes().array() + 2.0 * margin_).round().cast<int>();
    image = cv::Mat(std::max(pixels.y(), size / 4), pixels.x(), CV_8UC3, kWhite);
  }

  cv::Point At(const Eigen::Vector2d& p) const {
    constexpr int kUnit = 1 << kFraction;
    const Eigen::Vector2d uv = scale_ * (p - low_) + Eigen::Vector2d::Constant(margin_);
    return {static_cast<int>(std::lround(kUnit * uv.x())),
            static_cast<int>(std::lround(kUnit * (image.rows - 1 - uv.y())))};
  }
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& colour,
            int width) {
    cv::line(image, At(a), At(b), colour, width, cv::LINE_AA, kFraction);
  }
  void Dot(const Eigen::Vector2d& p, const cv::Scalar& colour, double radius) {
    cv::circle(image, At(p), static_cast<int>(radius * (1 << kFraction)), colour, cv::FILLED,
               cv::LINE_AA, kFraction);
  }
  // Draws a bar of 1, 2 or 5 times a power of ten metres, at least a tenth of the picture's width.
  void DrawScale() {
    const double wanted = 0.1 * image.cols / scale_;
    const double power = std::pow(10.0, std::floor(std::log10(wanted)));
    double metres = 10.0 * power;
    for (const double step : {5.0, 2.0, 1.0}) {
      if (step * power >= wanted) metres = step * power;
    }
    const int left = static_cast<int>(margin_ / 2.0), bottom = image.rows - left;
    const int right = left + static_cast<int>(metres * scale_);
    cv::rectangle(image, {left, bottom - 4}, {right, bottom}, kInk, cv::FILLED);
    cv::putText(image, fmt::format("{:g} m", metres), {right + 8, bottom}, cv::FONT_HERSHEY_SIMPLEX,
                0.5, kInk, 1, cv::LINE_AA);
  }
  double scale() const { return scale_; }  // [px/m]

  cv::Mat image;

 private:
  Eigen::Vector2d low_;
  double margin_;
  double scale_;
};

// Returns the box of the whole path, and of the landmarks without the outermost percent on each
// side.
Eigen::AlignedBox2d BoxOf(const std::vector<Eigen::Vector2d>& landmarks, const Trajectory& path,
                          const Eigen::Matrix3d& R_GW) {
  Eigen::AlignedBox2d box;
  for (const StampedPose& pose : path) box.extend((R_GW * pose.pose.p()).head<2>());
  if (landmarks.empty()) return box;
  Eigen::Vector2d low, high;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector2d& p : landmarks) values.push_back(p[axis]);
    std::ranges::sort(values);
    low[axis] = values[values.size() / 100];
    high[axis] = values[values.size() - 1 - values.size() / 100];
  }
  return box.extend(low).extend(high);
}

// Draws the camera and the far edge of its image from above.
void DrawFrustum(const Pose& T_WC, const Eigen::Matrix3d& R_GW, double metres, Sheet& sheet) {
  const auto at = [&](double x, double z) {
    return (R_GW * (T_WC * Eigen::Vector3d(metres * x, 0.0, metres * z))).head<2>().eval();
  };
  const std::array<Eigen::Vector2d, 3> corners = {at(0.0, 0.0), at(-0.55, 1.0), at(0.55, 1.0)};
  for (std::size_t i = 0; i < 3; ++i) {
    sheet.Line(corners[i], corners[(i + 1) % 3], kKeyframe, 1);
  }
}

}  // namespace

SparseMap SurveyMap(const Map& map, SubmapId submap, const Trajectory& trajectory,
                    const Trajectory& keyframes, std::size_t observers) {
  SparseMap sparse;
  const std::vector<KeyFrameId> seen_by = map.KeyFramesOf(submap);
  sparse.trajectory = trajectory;
  sparse.keyframes = keyframes;
  for (const PointId id : map.SeenBy<MapPoint>(seen_by)) {
    const MapPoint& point = *map.Find(id);
    if (point.observations.size() >= observers) sparse.points_W.push_back(point.p_W);
  }
  for (const LineId id : map.SeenBy<MapLine>(seen_by)) {
    const MapLine& line = *map.Find(id);
    if (line.observations.size() >= observers) sparse.lines_W.push_back(line.segment_W);
  }
  return sparse;
}

cv::Mat DrawSparseMap(const SparseMap& map, const Eigen::Quaterniond& q_GW, int size) {
  if (map.points_W.empty() && map.lines_W.empty() && map.trajectory.empty()) return {};
  const Eigen::Matrix3d R_GW = q_GW.toRotationMatrix();
  const auto flat = [&](const Eigen::Vector3d& p_W) { return (R_GW * p_W).head<2>().eval(); };
  std::vector<Eigen::Vector2d> landmarks;
  for (const Eigen::Vector3d& p_W : map.points_W) landmarks.push_back(flat(p_W));
  for (const Segment3& line : map.lines_W) {
    landmarks.push_back(flat(line.p()));
    landmarks.push_back(flat(line.q()));
  }
  Sheet sheet(BoxOf(landmarks, map.trajectory, R_GW), size);
  for (const Eigen::Vector3d& p_W : map.points_W) sheet.Dot(flat(p_W), kPoint, 1.0);
  for (const Segment3& line : map.lines_W) sheet.Line(flat(line.p()), flat(line.q()), kLine, 1);
  const double frustum = 12.0 / sheet.scale();  // [m], a dozen pixels
  for (const StampedPose& pose : map.keyframes) DrawFrustum(pose.pose, R_GW, frustum, sheet);
  for (std::size_t i = 1; i < map.trajectory.size(); ++i) {
    sheet.Line(flat(map.trajectory[i - 1].pose.p()), flat(map.trajectory[i].pose.p()), kTrajectory,
               2);
  }
  sheet.DrawScale();
  return sheet.image;
}

}  // namespace highwall::apps
