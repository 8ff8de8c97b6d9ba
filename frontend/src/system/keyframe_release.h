#pragma once

#include <cstddef>
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

// Collects the contents of the next KeyframeEvent until it has been emitted, so that an exception
// of a callback loses nothing. Keyframes are added after a delay, when the following frames have
// revealed their dynamic objects.
class KeyframeRelease {
 public:
  // wait: [s] >= 0.
  explicit KeyframeRelease(double wait) : wait_(FromSeconds(wait)) {}

  // Adds a keyframe to the queue, in the order of time. image: with corrected depth; its pixels are
  // copied, since the caller may overwrite them. dynamic: current dynamic mask, may be empty.
  void Add(KeyFrameId id, const RgbdImage& image, const cv::Mat& dynamic);
  // Records that a keyframe has left the map.
  void Remove(KeyFrameId id);
  // Records that keyframes have moved.
  void Move() { moved_ = true; }

  // Returns the dynamic mask of an active keyframe by all frames so far; may be empty.
  using MaskOf = std::function<cv::Mat(KeyFrameId)>;
  // Returns the changes, and the keyframes that have waited long enough at `now`, with their
  // current places.
  KeyframeEvent Event(Stamp now, const Map& map, const MaskOf& mask) const;
  // Returns the same with all waiting keyframes and with all places.
  KeyframeEvent LastEvent(const Map& map, const MaskOf& mask) const;
  // Of the images of the waiting keyframes.
  std::size_t MemoryBytes() const;
  // Drops the changes that these two functions have returned.
  void SetEmitted(Stamp now);
  void SetLastEmitted();

 private:
  struct Waiting {
    KeyFrameId id;
    Stamp stamp = 0;
    cv::Mat depth, bgr, dynamic, noise_factor;
  };

  bool HasWaited(const Waiting& waiting, Stamp now) const { return now - waiting.stamp >= wait_; }
  // Appends the view of a keyframe, unless it is no longer in the map.
  static void AddView(const Waiting& waiting, const Map& map, const MaskOf& mask,
                      std::vector<KeyframeView>* views);

  Stamp wait_;
  std::deque<Waiting> waiting_;
  std::vector<std::int64_t> removed_;
  bool moved_ = false;
};

}  // namespace highwall
