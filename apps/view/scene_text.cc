#include "view/scene_text.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

#include "files/json_text.h"
#include "report/base64.h"
#include "report/report_number.h"

namespace highwall::apps {
namespace {

using nlohmann::json;

// Multiples of this share of a range, modulo the range, are spread over it however many they are.
constexpr double kGoldenRatio = 0.6180339887498949;

char LetterOf(TrackingState state) {
  return ToString(state)[0];  // i: initializing; the letters of the states differ but for inertial
}

json RoundedList(std::span<const FrameRecord> frames, float FrameRecord::*member, double step) {
  json values = json::array();
  for (const FrameRecord& frame : frames) {
    values.push_back(Rounded(static_cast<double>(frame.*member), step));
  }
  return values;
}

template <class Value>
json List(std::span<const FrameRecord> frames, Value FrameRecord::*member) {
  json values = json::array();
  for (const FrameRecord& frame : frames) values.push_back(frame.*member);
  return values;
}

}  // namespace

KeyframeCloudSample SampleKeyframe(const KeyframeView& view, const DepthUnprojector& unprojector,
                                   float min_depth, float max_depth, std::size_t limit) {
  KeyframeCloudSample sample{.id = static_cast<std::int32_t>(view.id)};
  if (!view.depth || view.depth->empty()) return sample;
  const cv::Mat& depth = *view.depth;
  const auto pixels = static_cast<double>(depth.total());
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(limit)))));
  const auto columns = static_cast<std::size_t>((depth.cols + stride - 1) / stride);
  const auto rows = static_cast<std::size_t>((depth.rows + stride - 1) / stride);
  const std::size_t count = columns * rows;
  auto step = static_cast<std::size_t>(kGoldenRatio * static_cast<double>(count)) + 1;
  while (std::gcd(step, count) != 1) ++step;
  const bool masked = view.dynamic && !view.dynamic->empty();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * step % count;
    const int u = std::min(depth.cols - 1, stride / 2 + stride * static_cast<int>(at % columns));
    const int v = std::min(depth.rows - 1, stride / 2 + stride * static_cast<int>(at / columns));
    const float z = depth.at<float>(v, u);
    if (!(z >= min_depth && z <= max_depth)) continue;
    if (masked && view.dynamic->at<std::uint8_t>(v, u) != 0) continue;
    sample.points_C.push_back(unprojector.Unproject(u, v, z));
    const cv::Vec3b bgr =
        view.bgr && !view.bgr->empty() ? view.bgr->at<cv::Vec3b>(v, u) : cv::Vec3b(160, 160, 160);
    for (const int channel : {2, 1, 0}) sample.rgb.push_back(bgr[channel]);
  }
  return sample;
}

std::string FramesBlock(std::size_t first, std::span<const FrameRecord> frames) {
  json t = json::array(), p = json::array();
  std::string states;
  for (const FrameRecord& frame : frames) {
    t.push_back(Rounded(frame.seconds, 1e-3));
    for (int k = 0; k < 3; ++k) p.push_back(Rounded(static_cast<double>(frame.p_K[k]), 1e-3));
    states += frame.state == TrackingState::kInertial ? 'p' : LetterOf(frame.state);
  }
  return JsonText(json{{"kind", "frames"},
                       {"first", first},
                       {"t", std::move(t)},
                       {"state", states},
                       {"anchor", List(frames, &FrameRecord::anchor)},
                       {"p", std::move(p)},
                       {"points", List(frames, &FrameRecord::points)},
                       {"lines", List(frames, &FrameRecord::lines)},
                       {"features", RoundedList(frames, &FrameRecord::features, 0.01)},
                       {"pose", RoundedList(frames, &FrameRecord::pose, 0.01)},
                       {"mapping", RoundedList(frames, &FrameRecord::mapping, 0.01)},
                       {"frame", RoundedList(frames, &FrameRecord::total, 0.01)},
                       {"weight", RoundedList(frames, &FrameRecord::weight, 1e-3)}});
}

std::string KeyframesBlock(std::span<const KeyframeRecord> keyframes) {
  json ids = json::array(), worlds = json::array(), active = json::array();
  std::vector<float> poses;
  for (const KeyframeRecord& keyframe : keyframes) {
    ids.push_back(keyframe.id);
    worlds.push_back(keyframe.world);
    active.push_back(keyframe.active ? 1 : 0);
    for (int i = 0; i < 7; ++i) poses.push_back(static_cast<float>(keyframe.T_WC.data()[i]));
  }
  return JsonText(json{{"kind", "keyframes"},
                       {"id", std::move(ids)},
                       {"world", std::move(worlds)},
                       {"active", std::move(active)},
                       {"poses", Base64Of(std::span<const float>(poses))}});
}

std::string LoopsBlock(std::span<const LoopRecord> loops) {
  json list = json::array();
  for (const LoopRecord& loop : loops) {
    list.push_back({loop.from, loop.to, loop.accepted ? 1 : 0, loop.merged ? 1 : 0});
  }
  return JsonText(json{{"kind", "loops"}, {"loops", std::move(list)}});
}

std::string CloudBlock(const KeyframeCloudSample& sample) {
  float size = 1e-3F;
  for (const Eigen::Vector3f& p : sample.points_C) size = std::max(size, p.cwiseAbs().maxCoeff());
  const float step = size / std::numeric_limits<std::int16_t>::max();
  std::vector<std::int16_t> positions;
  positions.reserve(3 * sample.points_C.size());
  for (const Eigen::Vector3f& p : sample.points_C) {
    for (int k = 0; k < 3; ++k) {
      positions.push_back(static_cast<std::int16_t>(std::lround(p[k] / step)));
    }
  }
  return JsonText(json{{"kind", "cloud"},
                       {"id", sample.id},
                       {"count", sample.points_C.size()},
                       {"step", step},
                       {"positions", Base64Of(std::span<const std::int16_t>(positions))},
                       {"colours", Base64Of(std::span<const std::uint8_t>(sample.rgb))}});
}

std::string OctreeBlock(std::int32_t world, double size, const Eigen::Vector3i& corner, int side,
                        std::span<const std::uint16_t> cells) {
  return JsonText(json{{"kind", "octree"},
                       {"world", world},
                       {"size", size},
                       {"corner", {corner.x(), corner.y(), corner.z()}},
                       {"side", side},
                       {"count", cells.size()},
                       {"cells", Base64Of(cells)}});
}

}  // namespace highwall::apps
