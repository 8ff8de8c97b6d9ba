#include <highwall/mapping/octree_size.h>

#include <algorithm>
#include <cmath>

namespace highwall {

double PredictOctreeBytes(std::span<const DepthView> views, const DepthUnprojector& unprojector,
                          const OctomapBuilderOptions& options) {
  options.Validate();
  OctomapBuilderOptions fine_options = options, coarse_options = options;
  fine_options.resolution = std::max(0.1, 2.0 * options.resolution);
  coarse_options.resolution = 2.0 * fine_options.resolution;
  OctomapBuilder fine(fine_options), coarse(coarse_options);
  for (const DepthView& view : views) {
    fine.Insert(view.depth, unprojector, view.T_WC);
    coarse.Insert(view.depth, unprojector, view.T_WC);
  }
  if (coarse.NodeCount() == 0) return 0.0;
  const auto bytes = static_cast<double>(fine.MemoryBytes());
  const double exponent =
      std::clamp(std::log2(bytes / static_cast<double>(coarse.MemoryBytes())), 2.0, 3.0);
  return bytes * std::pow(fine_options.resolution / options.resolution, exponent);
}

}  // namespace highwall
