#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/line3.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/map/map.h>

namespace highwall::apps {

// Map of the front end: landmarks and camera trajectory.
struct SparseMap {
  std::vector<Eigen::Vector3d> points_W;  // [m]
  std::vector<Segment3> lines_W;          // [m]
  Trajectory trajectory, keyframes;       // T_WC
};

// Selects the landmarks of a submap that at least `observers` keyframes observe: others are not yet
// reliable. trajectory, keyframes: in its world.
SparseMap SurveyMap(const Map& map, SubmapId submap, const Trajectory& trajectory,
                    const Trajectory& keyframes, std::size_t observers = 3);

// Draws the sparse map from above, as in papers: points black, lines green, the camera path red,
// keyframes as blue frusta, and a scale bar. Returns CV_8UC3 with `size` pixels along the longer
// edge; the few landmarks far from all others are omitted. R_GW: to a frame whose z points up. An
// empty map gives an empty image. size: [px] > 0.
cv::Mat DrawSparseMap(const SparseMap& map, const Eigen::Quaterniond& R_GW, int size);

}  // namespace highwall::apps
