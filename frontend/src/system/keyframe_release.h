#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/keyframe_event.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Delay [s] after which a moving object has usually left its place.
inline constexpr double kReleaseDelay = 2.0;

KeyframePlace PlaceOf(const KeyFrame& keyframe, const Map& map);
std::map<std::int64_t, KeyframePlace> PlacesOf(const Map& map);

// Delayed queue of the keyframes that KeyframeEvent adds. Each waits until the following frames
// have revealed its dynamic objects.
class KeyframeRelease {
 public:
  // wait: [s] >= 0.
  explicit KeyframeRelease(double wait) : wait_(FromSeconds(wait)) {}

  // In the order of time. image: with corrected depth; its pixels are copied, for the caller may
  // use them again. dynamic: the mask known at this time, may be empty.
  void Add(KeyFrameId id, const RgbdImage& image, const cv::Mat& dynamic);
  void Remove(KeyFrameId id);

  // Returns the dynamic mask of an active keyframe by all frames so far; may be empty.
  using MaskOf = std::function<cv::Mat(KeyFrameId)>;
  // Releases the keyframes that have waited long enough at `now`, with their current places.
  std::vector<KeyframeView> Take(Stamp now, const Map& map, const MaskOf& mask);
  std::vector<KeyframeView> TakeAll(const Map& map, const MaskOf& mask);
  // Returns the same as TakeAll(), but keeps them in the queue.
  std::vector<KeyframeView> All(const Map& map, const MaskOf& mask) const;

 private:
  struct Waiting {
    KeyFrameId id;
    Stamp stamp = 0;
    cv::Mat depth, bgr, dynamic;
  };

  // Appends the view of a keyframe, unless it is no longer in the map.
  static void AddView(const Waiting& waiting, const Map& map, const MaskOf& mask,
                      std::vector<KeyframeView>* views);

  Stamp wait_;
  std::deque<Waiting> waiting_;
};

}  // namespace highwall
