#include <highwall/mapping/dense_mapper.h>

#include <highwall/mapping/map_comparison.h>

#include "ground_plane.h"

namespace highwall {

void AddGrid(std::span<const Pose> cameras, bool level, const OccupancyGridOptions& options,
             DenseMap& dense) {
  Eigen::Vector3d camera_up_W = Eigen::Vector3d::Zero(), viewpoint_W = Eigen::Vector3d::Zero();
  for (const Pose& T_WC : cameras) {
    camera_up_W -= T_WC.R().col(1);
    viewpoint_W += T_WC.p() / static_cast<double>(cameras.size());
  }
  OccupancyGridOptions grid = options;
  if (!level && !camera_up_W.isZero(1e-6)) {
    const auto plane =
        FitGroundPlane(OccupiedCentres(dense.octree), camera_up_W, viewpoint_W,
                       {.max_tilt = 60.0, .thickness = dense.octree.options().resolution});
    grid.R_GW = UprightRotation(plane ? plane->up_W : camera_up_W);
  }
  dense.R_GW = grid.R_GW;
  dense.ground_height = FloorHeight(dense.octree, grid.R_GW);
  if (dense.ground_height) grid.ground_height = *dense.ground_height;
  dense.grid = ProjectToGrid(dense.octree, grid);
}

}  // namespace highwall
