#pragma once

#include <deque>
#include <functional>
#include <span>

#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "pose/landmark_motion.h"

namespace highwall {

// A depth grid, where it was taken, and the range of the depths about each cell.
struct PosedDepth {
  PosedDepth(Stamp stamp, const cv::Mat& depth, const Pose& T_WC);

  Stamp stamp = 0;
  cv::Mat depth;     // CV_32FC1 [m], DepthGrid::Sample
  cv::Mat nearest;   // the least depth of a cell and its neighbours; 0: too few have one
  cv::Mat farthest;  // the greatest
  cv::Mat moving;    // what moved here as far as was known (FindMoving); may be empty
  Pose T_WC;
};

// Whether the landmarks on a surface have moved, given its index; moving: the cells (not 0) that
// are known to, which say nothing of others.
using SurfaceTest =
    std::function<bool(const DepthSurfaces& surfaces, int surface, const cv::Mat& moving)>;

// What tells of whole surfaces that they move, beside the depth of references.
struct SurfaceClues {
  cv::Mat depth{}, moving{};  // of the frame before, and what moved in it; empty: not known
  SurfaceTest moved{};        // may be empty
};

// What moves: the cells of `view` (CV_8UC1, not 0; empty: nothing does) that most of the references
// contradict, in clusters that are more than an edge, and cells of the same surface of which
// nothing is known. A reference contradicts a point where it looked through it at something farther
// away (255), and where it saw something before it that the view in turn looks through (127: it may
// be what that has hidden); it confirms a point at whose depth it has a surface, unless that moved
// (254, 255) a moment ago. A point out of its view, or behind what still stands there, it says
// nothing of. Surfaces that have not been in place for long move as well (254) if their landmarks
// do, or if most of them showed a surface that moved (254) in the frame before.
cv::Mat FindMoving(const PosedDepth& view, std::span<const PosedDepth> references,
                   const DepthGrid& grid, const DepthNoise& noise,
                   const MovingObjectOptions& options, const SurfaceClues& clues = {});

// The cells of a mask and those about them: at the border of a surface the sensor mixes both sides.
cv::Mat WithBorder(const cv::Mat& cells);

// A depth grid that is 0 in the cells of `moving` and those about them; itself where that is empty.
cv::Mat Standing(const cv::Mat& depth, const cv::Mat& moving);

// The depth of the last seconds, and what moves against it.
class MovingObjects {
 public:
  MovingObjects(const PinholeCamera& camera, const DepthNoise& noise,
                const MovingObjectOptions& options);

  const DepthGrid& grid() const { return grid_; }

  // The cells of a frame that move, as FindMoving; depth: its grid, empty where it has none;
  // submap: whose world T_WC is in. The frame itself may be among those remembered. moved: of its
  // landmarks, where they are known.
  cv::Mat Find(Stamp stamp, const cv::Mat& depth, const Pose& T_WC, const Map& map, SubmapId submap,
               const SurfaceTest& moved = {}) const;
  // Remembers a frame, for the next one and, where the last such is old enough, for longer.
  // reference: a keyframe of the map, which the pose follows; moving: what Find found in it.
  void Remember(Stamp stamp, const cv::Mat& depth, const Pose& T_WC, const cv::Mat& moving,
                KeyFrameId reference, const Map& map);

 private:
  struct Remembered {
    PosedDepth view;    // as it was seen
    AnchoredPose pose;  // as it is now
  };

  DepthGrid grid_;
  DepthNoise noise_;
  MovingObjectOptions options_;
  std::deque<Remembered> recent_;
  // The last frame.
  Stamp before_ = 0;
  cv::Mat depth_before_, moving_before_;
};

}  // namespace highwall
