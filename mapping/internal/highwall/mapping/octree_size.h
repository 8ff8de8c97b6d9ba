#pragma once

#include <span>

#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/octomap_builder.h>

namespace [[gnu::visibility("default")]] highwall {

// Predicts the memory in bytes of the octree of these views at options.resolution before it is
// built, from octrees at 0.2 m and 0.1 m (or 4 and 2 times the resolution if that is coarser), by
// the power law of their sizes (the exponent lies between 2, a surface, and 3, a volume). Accurate
// to a factor of two. Throws InvalidArgument as OctomapBuilder does.
double PredictOctreeBytes(std::span<const DepthView> views, const DepthUnprojector& unprojector,
                          const OctomapBuilderOptions& options);

}  // namespace highwall
