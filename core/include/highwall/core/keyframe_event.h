#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

// Images are those of OpenCV, which core itself does not need.
namespace cv {
class Mat;
}

namespace [[gnu::visibility("default")]] highwall {

// Where a keyframe is: its pose in the world that it belongs to. Keyframes that nothing connects
// yet are in different worlds.
struct KeyframePlace {
  Pose T_WC;
  std::int32_t world = 0;
};

// A keyframe with its images, which are shared and must not be changed.
struct KeyframeView {
  std::int64_t id = 0;
  Stamp stamp = 0;
  std::shared_ptr<const cv::Mat> depth{};  // CV_32FC1 [m], corrected; 0 where nothing was measured
  std::shared_ptr<const cv::Mat> bgr{};    // CV_8UC3 of the same size
  std::shared_ptr<const cv::Mat> dynamic{};       // CV_8UC1 of the same size, not 0 where an object
                                                  // moves; null or empty: none does
  std::shared_ptr<const cv::Mat> noise_factor{};  // CV_32FC1 of the same size, of the noise of
                                                  // depth; null or empty: 1
  KeyframePlace place{};
};

// How the keyframes of a SLAM system have changed. Consumers such as DenseMapper apply `removed`,
// then `places`, then `added`.
struct KeyframeEvent {
  std::vector<std::int64_t> removed{};
  // All keyframes that exist, if some of them have moved: those that are missing no longer exist.
  std::optional<std::map<std::int64_t, KeyframePlace>> places{};
  std::vector<KeyframeView> added{};  // in the order of time, each once

  bool empty() const { return removed.empty() && !places && added.empty(); }
};

}  // namespace highwall
