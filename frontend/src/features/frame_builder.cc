#include "features/frame_builder.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/features/make_point_extractor.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/internal/worker_team.h>

#include "features/line_validation.h"
#include "features/point_validation.h"
#include "features/segment_depth.h"

namespace highwall {
namespace {

LineSegment Undistorted(const LineSegment& raw, const PinholeCamera& camera) {
  return {camera.UndistortPixel(raw.s.cast<double>()).cast<float>(),
          camera.UndistortPixel(raw.e.cast<double>()).cast<float>()};
}

// A depth reading and its largest difference to the neighbouring readings.
struct DepthReading {
  double depth = 0.0;   // [m] 0 where missing or out of range
  double noise = 1.0;   // RgbdImage::noise_factor
  double spread = 0.0;  // [m] largest difference to a neighbour
};

DepthReading ReadDepth(const RgbdImage& image, const cv::Point2f& uv, double min_depth,
                       double max_depth) {
  const cv::Mat& depth = image.depth;
  const int x = static_cast<int>(std::lround(uv.x)), y = static_cast<int>(std::lround(uv.y));
  const auto at = [&](int u, int v) {
    if (u < 0 || v < 0 || u >= depth.cols || v >= depth.rows) return 0.0;
    const double d = static_cast<double>(depth.at<float>(v, u));
    return d >= min_depth && d <= max_depth ? d : 0.0;
  };
  DepthReading reading{.depth = at(x, y)};
  if (reading.depth > 0.0 && !image.noise_factor.empty()) {
    reading.noise = static_cast<double>(image.noise_factor.at<float>(y, x));
  }
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const double neighbour = at(x + du, y + dv);
      if (neighbour > 0.0) {
        reading.spread = std::max(reading.spread, std::abs(neighbour - reading.depth));
      }
    }
  }
  return reading;
}

// Sampled on every fourth row; blur reduces the differences between neighbouring pixels.
double Sharpness(const cv::Mat& gray) {
  constexpr int kRowStep = 4;
  std::int64_t sum = 0, count = 0;
  for (int v = 0; v < gray.rows; v += kRowStep) {
    const std::uint8_t* row = gray.ptr<std::uint8_t>(v);
    for (int u = 1; u < gray.cols; ++u) sum += std::abs(row[u] - row[u - 1]);
    count += gray.cols - 1;
  }
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : 0.0;
}

// Returns the kind of a user-defined extractor after validation.
const FeatureType& Sound(const FeatureType& kind) {
  kind.Validate();
  return kind;
}

}  // namespace

FrameBuilder::FrameBuilder(const RgbdSensor& sensor, const FrameBuilderOptions& options,
                           std::shared_ptr<PointExtractor> points,
                           std::shared_ptr<LineExtractor> lines, bool parallel,
                           double depth_spread_share, RunProfile* profile)
    : sensor_(sensor),
      options_(options),
      depth_spread_share_(depth_spread_share),
      points_(points ? std::move(points) : MakePointExtractor(options)),
      descriptor_bits_(Sound(feature_type()).descriptor, feature_type().columns),
      users_lines_(lines != nullptr),
      lines_(lines ? std::move(lines) : std::make_shared<LbdLineExtractor>(options.lines)),
      depth_grid_(sensor.camera),
      profile_(profile) {
  sensor_.Validate();
  options_.Validate();
  const bool both = options.use_lines && options.use_points;
  team_ = std::make_unique<WorkerTeam>(parallel && both ? 2 : 1, ThreadLabel{"features", profile});
}

FrameBuilder::~FrameBuilder() = default;

void FrameBuilder::Check(const RgbdImage& image) const {
  const PinholeCamera& camera = sensor_.camera;
  HIGHWALL_REQUIRE(image.bgr.type() == CV_8UC3 && image.depth.type() == CV_32FC1,
                   "FrameBuilder: colour must be CV_8UC3 and depth CV_32FC1");
  HIGHWALL_REQUIRE(image.bgr.size() == image.depth.size(),
                   "FrameBuilder: colour and depth differ in size");
  HIGHWALL_REQUIRE(image.noise_factor.empty() || (image.noise_factor.type() == CV_32FC1 &&
                                                  image.noise_factor.size() == image.depth.size()),
                   "FrameBuilder: RgbdImage::noise_factor must be CV_32FC1 of the size of depth");
  HIGHWALL_REQUIRE(image.bgr.cols == camera.width && image.bgr.rows == camera.height,
                   "FrameBuilder: the image is " + std::to_string(image.bgr.cols) + " x " +
                       std::to_string(image.bgr.rows) + ", the camera " +
                       std::to_string(camera.width) + " x " + std::to_string(camera.height));
}

std::shared_ptr<const FrameFeatures> FrameBuilder::Build(const RgbdImage& image,
                                                         FrameBuilderTimes* times) {
  RgbdImage as_given = image;
  return Build(&as_given, {}, times);
}

std::shared_ptr<const FrameFeatures> FrameBuilder::Build(RgbdImage* image,
                                                         const DepthChange& change,
                                                         FrameBuilderTimes* times) {
  Check(*image);
  cv::Mat gray;
  cv::cvtColor(image->bgr, gray, cv::COLOR_BGR2GRAY);

  auto features = std::make_shared<FrameFeatures>();
  features->sharpness = Sharpness(gray);
  features->brightness = cv::mean(gray)[0];
  features->gray_grid = depth_grid_.Average(gray);
  features->gray = gray;
  FrameBuilderTimes elapsed;
  ExtractedPoints points;
  LineFeatures lines;
  const auto change_depth = [&] {
    const StageTimer timer(profile_, "depth");
    if (change) change(image);
    features->depth_grid = depth_grid_.Sample(image->depth, sensor_.min_depth, sensor_.max_depth);
  };
  const auto extract_lines = [&] {
    if (options_.use_lines) lines = lines_->Extract(gray);
  };
  const auto extract_points = [&] {
    if (options_.use_points) points = points_->Extract(gray);
  };
  // The caller starts with the first task immediately: where colour is late, it takes longest.
  team_->Run(3, [&](std::size_t, std::size_t task) {
    if (task == 0) {
      change_depth();
    } else if (task == 1) {
      const StageTimer timer(profile_, "points", &elapsed.points);
      extract_points();
    } else {
      const StageTimer timer(profile_, "lines", &elapsed.lines);
      extract_lines();
    }
  });
  team_->Run(2, [&](std::size_t, std::size_t task) {
    if (task == 0) {
      const StageTimer timer(profile_, "lines", &elapsed.lines);
      BuildLines(std::move(lines), *image, *features);
    } else if (options_.use_points) {
      const StageTimer timer(profile_, "points", &elapsed.points);
      BuildPoints(std::move(points), *image, *features);
    }
  });
  if (times != nullptr) *times = elapsed;
  return features;
}

void FrameBuilder::BuildPoints(ExtractedPoints extracted, const RgbdImage& image,
                               FrameFeatures& features) const {
  ValidatePoints(extracted, feature_type(), features.gray.size());
  features.points.reserve(extracted.keypoints.size());
  for (cv::KeyPoint& keypoint : extracted.keypoints) {
    PointFeature feature;
    const DepthReading reading =
        ReadDepth(image, keypoint.pt, sensor_.min_depth, sensor_.max_depth);
    if (reading.depth > 0.0) {
      feature.depth = reading.depth;
      feature.depth_sigma = std::hypot(reading.noise * sensor_.depth_noise.Sigma(reading.depth),
                                       depth_spread_share_ * reading.spread);
    }
    feature.uv = sensor_.camera.UndistortPixel({keypoint.pt.x, keypoint.pt.y});
    feature.pixel = Eigen::Vector2f(keypoint.pt.x, keypoint.pt.y);
    feature.octave = keypoint.octave;
    feature.angle = keypoint.angle;
    feature.low_contrast = keypoint.response < feature_type().low_contrast_response;
    features.points.push_back(feature);
    // The grid holds undistorted positions, in which projections are given.
    keypoint.pt =
        cv::Point2f(static_cast<float>(feature.uv.x()), static_cast<float>(feature.uv.y()));
  }
  features.point_grid = FeatureGrid(extracted.keypoints, features.gray.size());
  features.point_descriptors = descriptor_bits_.Of(extracted.descriptors);
}

void FrameBuilder::BuildLines(LineFeatures lines, const RgbdImage& image,
                              FrameFeatures& features) const {
  if (users_lines_) {
    ValidateLines(lines, features.gray.size());
    lines.descriptors = lines.descriptors.clone();  // its memory may be used again
  }
  features.lines.reserve(lines.segments.size());
  for (const LineSegment& raw : lines.segments) {
    LineFeature feature;
    feature.segment = Undistorted(raw, sensor_.camera);
    feature.segment_C =
        FitSegmentDepth(feature.segment, image.depth, sensor_, kMinMeasured, image.noise_factor);
    features.lines.push_back(feature);
  }
  features.line_descriptors = lines.descriptors;
}

}  // namespace highwall
