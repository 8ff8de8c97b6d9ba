#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/depth_smoothing.h>

namespace [[gnu::visibility("default")]] highwall {

// Makes depth fit for a map: smooth where the sensor is noisy (SmoothDepth), and without what the
// frames before and after speak against (KeepAgreedDepth), if they are of the same layer. So a
// frame comes out when the next one has come in; three are held at a time.
class DepthFilter {
 public:
  // voxel_size: [m] of the map; noise of a quarter of it may stay. Throws InvalidArgument for a
  // camera without sigma.
  DepthFilter(const DepthCamera& camera, double voxel_size);

  // Frames in the order of time. What comes out, if anything, is the frame before. Throws
  // InvalidArgument for depth that is not of the camera's size.
  std::optional<KeyframeImage> Push(KeyframeImage next);
  // The last frame.
  std::optional<KeyframeImage> Flush();
  // Of a frame inside; does nothing where there is none.
  void Remove(std::int64_t id);
  // Where the frames are now; those inside that are not among them are removed.
  void SetPoses(const std::map<std::int64_t, KeyframePose>& poses);

 private:
  struct Held {
    KeyframeImage frame;
    bool done = false;  // it has come out, and still votes
  };
  // The last frame but `newer`, with the votes of its neighbours.
  std::optional<KeyframeImage> TakeOut(std::size_t newer);

  DepthCamera camera_;
  DepthSmoothingOptions smoothing_;
  DepthUnprojector unprojector_;
  std::deque<Held> held_;
};

}  // namespace highwall
