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

// Parameters of the detection of dynamic objects that are no options of a user.
struct DynamicObjectParameters {
  double settled = 1.5;   // [s] > 0: a surface seen in place this long before or after is static
  double interval = 0.5;  // [s] > 0: between the frames that are stored
  double history = 4.0;   // [s] > interval: how long they are stored
  int min_surface = 40;   // >= 1 [cells] of a surface that is judged by its landmarks
  // (0, 1]: maximum size of such a surface, as a share of the cells with depth
  double max_surface = 0.5;
  LandmarkMotionOptions landmarks{};  // when they indicate that a surface moves
};

// Depth grid with its pose, and the range of the depths around each cell.
struct PosedDepth {
  PosedDepth(Stamp stamp, const cv::Mat& depth, const Pose& T_WC);

  Stamp stamp = 0;
  cv::Mat depth;     // CV_32FC1 [m], DepthGrid::Sample
  cv::Mat nearest;   // minimum depth of a cell and its neighbours; 0: too few have one
  cv::Mat farthest;  // maximum depth
  cv::Mat moving;    // its dynamic mask (FindDynamic), if known; may be empty
  Pose T_WC;
};

// Returns whether the landmarks on a surface, given by its index, have moved; moving: the cells
// (not 0) known to be dynamic, which give no evidence about others.
using SurfaceTest =
    std::function<bool(const DepthSurfaces& surfaces, int surface, const cv::Mat& moving)>;

// Evidence for the motion of whole surfaces, in addition to the depth of references.
struct SurfaceHistory {
  cv::Mat depth{}, moving{};  // of the previous frame, and its dynamic mask; empty: unknown
  SurfaceTest moved{};        // may be empty
};

// Returns the dynamic mask: the cells of `view` (CV_8UC1, not 0; empty: none) that most of the
// references contradict, in clusters that are more than an edge, and cells of the same surface
// without evidence. A reference contradicts a point if it observed a farther surface through it
// (255), or if it observed a nearer surface that the view in turn looks through (127: that surface
// may have hidden the point). It confirms a point at whose depth it has a surface, unless that
// surface was dynamic (254, 255) a short time ago. It gives no evidence of a point outside its
// view, or behind a surface that is still there. Surfaces that have not been in place for long are
// dynamic as well (254) if their landmarks have moved, or if most of their cells showed a dynamic
// surface (254) in the previous frame. max_share: DynamicObjectOptions.
cv::Mat FindDynamic(const PosedDepth& view, std::span<const PosedDepth> references,
                    const DepthGrid& grid, const DepthNoise& noise,
                    const DynamicObjectParameters& parameters = {},
                    const SurfaceHistory& history = {},
                    double max_share = DynamicObjectOptions().max_share);

// Dilates a mask by one cell: at the border of a surface the sensor mixes both sides.
cv::Mat WithBorder(const cv::Mat& cells);

// Returns the depth grid with 0 in the cells of `moving` and their neighbours; unchanged if
// `moving` is empty.
cv::Mat Standing(const cv::Mat& depth, const cv::Mat& moving);

// Dynamic object detector: keeps the depth of the last seconds and finds changes against it.
class DynamicObjects {
 public:
  DynamicObjects(const PinholeCamera& camera, const DepthNoise& noise,
                 const DynamicObjectOptions& options,
                 const DynamicObjectParameters& parameters = {});

  const DepthGrid& grid() const { return grid_; }

  // Returns the dynamic mask of a frame, as FindDynamic; depth: its grid, empty if it has none;
  // submap: in whose world T_WC is. The frame itself may be among the references. moved: the test
  // of its landmarks, if available.
  cv::Mat Find(Stamp stamp, const cv::Mat& depth, const Pose& T_WC, const Map& map, SubmapId submap,
               const SurfaceTest& moved = {}) const;
  // Keeps a frame as the previous one and, if the newest reference is old enough, as a reference.
  // reference: a keyframe of the map that the pose is anchored to; moving: the mask that Find
  // returned for it.
  void Remember(Stamp stamp, const cv::Mat& depth, const Pose& T_WC, const cv::Mat& moving,
                KeyFrameId reference, const Map& map);

 private:
  struct Remembered {
    PosedDepth view;    // as it was observed
    AnchoredPose pose;  // current pose
  };

  DepthGrid grid_;
  DepthNoise noise_;
  DynamicObjectOptions options_;
  DynamicObjectParameters parameters_;
  std::deque<Remembered> recent_;
  // The previous frame.
  Stamp before_ = 0;
  cv::Mat depth_before_, moving_before_;
};

}  // namespace highwall
