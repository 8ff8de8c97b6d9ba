#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/depth_smoothing.h>

namespace [[gnu::visibility("default")]] highwall {

// Filters depth for mapping: smooths it where the sensor is noisy (SmoothDepth) and removes depth
// that is inconsistent with the previous and the next frame (KeepAgreedDepth), if they are of the
// same layer. A frame is therefore returned when the next one has been added; three are held at a
// time.
class DepthFilter {
 public:
  // voxel_size: [m] of the map; noise of up to a quarter of it is tolerated. Throws InvalidArgument
  // for a camera without sigma.
  DepthFilter(const DepthCamera& camera, double voxel_size);

  // Adds a frame, in the order of time, and returns the previous frame, if any. Throws
  // InvalidArgument for depth that is not of the camera's size.
  std::optional<KeyframeImage> Push(KeyframeImage next);
  // Returns the last frame.
  std::optional<KeyframeImage> Flush();
  // Removes a held frame; does nothing if there is no such frame.
  void Remove(std::int64_t id);
  // Sets the current poses of the held frames; those without a pose are removed.
  void SetPoses(const std::map<std::int64_t, KeyframePose>& poses);
  // Of the images of the held frames.
  std::size_t MemoryBytes() const;

 private:
  struct Held {
    KeyframeImage frame;
    bool done = false;  // already returned, but still votes
  };
  // Returns the frame that has `newer` frames after it, filtered by the votes of its neighbours.
  std::optional<KeyframeImage> TakeOut(std::size_t newer);

  DepthCamera camera_;
  DepthSmoothingOptions smoothing_;
  DepthUnprojector unprojector_;
  std::deque<Held> held_;
};

}  // namespace highwall
