#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <highwall/core/line3.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/map/map.h>

namespace highwall::apps {

// What the front end built: landmarks and where the camera was.
struct SparseMap {
  std::vector<Eigen::Vector3d> points_W;  // [m]
  std::vector<Segment3> lines_W;          // [m]
  Trajectory trajectory, keyframes;       // T_WC
};

// Landmarks of a submap that were seen by at least `observers` keyframes: others are not sure yet.
// trajectory, keyframes: in its world.
SparseMap SurveyMap(const Map& map, SubmapId submap, const Trajectory& trajectory,
                    const Trajectory& keyframes, std::size_t observers = 3);

// The sparse map from above, as papers show it: points black, lines green, the way of the camera
// red, keyframes blue frusta, and a scale. CV_8UC3, of `size` pixels along the longer edge; the few
// landmarks far away from all others are left out of it. R_GW: to a frame whose z points up. An
// empty map gives an empty image. size: [px] > 0.
cv::Mat DrawSparseMap(const SparseMap& map, const Eigen::Quaterniond& R_GW, int size);

}  // namespace highwall::apps
