#include "view/frame_event.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "files/json_text.h"
#include "images/encode.h"
#include "report/base64.h"
#include "report/report_number.h"

namespace highwall::apps {
namespace {

using nlohmann::json;

constexpr int kWidth = 480;       // [px] of the image at most
constexpr int kMaskWidth = 160;   // [px] of the mask at most
constexpr int kQuality = 70;      // of the JPEG
constexpr double kSubpixels = 8;  // units of positions to a pixel

cv::Mat NotWider(const cv::Mat& image, int width, int interpolation) {
  if (image.cols <= width) return image;
  const double scale = static_cast<double>(width) / image.cols;
  cv::Mat small;
  cv::resize(image, small, {width, std::max(1, cvRound(scale * image.rows))}, 0, 0, interpolation);
  return small;
}

// Positions in the image as it was taken, two numbers each.
class Pixels {
 public:
  explicit Pixels(const PinholeCamera& camera)
      : camera_(camera), distorted_(camera.HasDistortion()) {}

  void Add(Eigen::Vector2d uv) {
    if (distorted_) {
      const Eigen::Vector2d m =
          camera_.Distort({(uv.x() - camera_.cx) / camera_.fx, (uv.y() - camera_.cy) / camera_.fy});
      uv = {camera_.fx * m.x() + camera_.cx, camera_.fy * m.y() + camera_.cy};
    }
    for (const double value : {uv.x(), uv.y()}) {
      values_.push_back(
          static_cast<std::uint16_t>(std::clamp(std::round(kSubpixels * value), 0.0, 65'535.0)));
    }
  }
  std::string Base64() const { return Base64Of(std::span<const std::uint16_t>(values_)); }

 private:
  const PinholeCamera& camera_;
  const bool distorted_;
  std::vector<std::uint16_t> values_;
};

// Those that are matched with the map first; "matched" is their number.
template <class Features, class Add>
json FeaturesJson(const Features& features, const std::vector<bool>& matched,
                  const PinholeCamera& camera, const Add& add) {
  Pixels pixels(camera);
  for (const bool first : {true, false}) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      if ((i < matched.size() && matched[i]) == first) add(features[i], &pixels);
    }
  }
  return {{"count", features.size()},
          {"matched", std::ranges::count(matched, true)},
          {"pixels", pixels.Base64()}};
}

void AddImage(const FramePicture& picture, const PinholeCamera& camera, json* event) {
  const FrameResult& result = picture.result;
  const cv::Mat small = NotWider(picture.bgr, kWidth, cv::INTER_AREA);
  (*event)["image"] = {{"width", picture.bgr.cols},
                       {"height", picture.bgr.rows},
                       {"jpeg", Base64Of(std::span<const std::uint8_t>(EncodeJpeg(small, kQuality)))}};
  if (result.features) {
    (*event)["points"] =
        FeaturesJson(result.features->points, result.matched.points, camera,
                     [](const PointFeature& point, Pixels* pixels) { pixels->Add(point.uv); });
    (*event)["lines"] = FeaturesJson(result.features->lines, result.matched.lines, camera,
                                     [](const LineFeature& line, Pixels* pixels) {
                                       pixels->Add(line.segment.s.cast<double>());
                                       pixels->Add(line.segment.e.cast<double>());
                                     });
  }
  if (!result.moving.empty()) {
    const cv::Mat mask = NotWider(result.moving, kMaskWidth, cv::INTER_NEAREST);
    cv::Mat shown;  // transparent where nothing moves
    cv::merge(std::array<cv::Mat, 4>{mask * 0.75, mask * 0.2, mask, mask * 0.5}, shown);
    (*event)["mask"] = Base64Of(std::span<const std::uint8_t>(EncodePng(shown)));
  }
}

json PoseJson(const Pose& T) {
  json values = json::array();
  for (int i = 0; i < 7; ++i) values.push_back(Rounded(T.data()[i], 1e-4));
  return values;
}

}  // namespace

std::string FrameEvent(const FramePicture& picture, const PinholeCamera& camera) {
  const FrameResult& result = picture.result;
  const FrameTimes& times = result.times;
  json event = {{"t", Rounded(picture.seconds, 1e-3)},
                {"done", picture.position.done},
                {"total", picture.position.total},
                {"dropped", picture.position.dropped},
                {"state", ToString(result.state)},
                {"reason", result.reason ? ToString(*result.reason) : ""},
                {"relocalized", result.relocalized},
                {"repeated", result.repeated},
                {"unobservable", result.unobservable_directions.size()},
                {"times",
                 {{"points", Rounded(times.points, 0.01)},
                  {"lines", Rounded(times.lines, 0.01)},
                  {"features", Rounded(times.features, 0.01)},
                  {"pose", Rounded(times.tracking, 0.01)},
                  {"mapping", Rounded(times.mapping, 0.01)},
                  {"loops", Rounded(times.loops, 0.01)},
                  {"frame", Rounded(times.total, 0.01)}}},
                {"map",
                 {{"keyframes", picture.map.keyframes},
                  {"points", picture.map.points},
                  {"lines", picture.map.lines},
                  {"submaps", picture.map.submaps},
                  {"loops", picture.map.loops},
                  {"refused", picture.map.refused},
                  {"merges", picture.map.merges}}}};
  if (HasPose(result.state)) {
    event["pose"] = PoseJson(result.T_WC);
    event["world"] = result.submap.value();
  }
  if (result.inertial) {
    event["imu"] = {{"status", ToString(result.inertial->status)},
                    {"reason", result.inertial->reason},
                    {"weight", Rounded(result.inertial->weight, 1e-4)}};
  }
  if (!picture.bgr.empty()) AddImage(picture, camera, &event);
  return JsonText(event);
}

}  // namespace highwall::apps
