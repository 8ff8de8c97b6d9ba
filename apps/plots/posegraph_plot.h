#pragma once

#include <filesystem>
#include <string>

#include <highwall/core/pose_graph.h>

namespace highwall::apps {

struct PoseGraphPlotText {
  std::string title;
  std::string before;  // above the left panel
  std::string after;   // above the right one
};

// Writes an SVG with two panels, the graph before and after optimization, viewed along the axis of
// least extent of the latter: odometry in blue, loops in grey, rejected loops in red. Throws
// IoError.
void WritePoseGraphPlot(const std::filesystem::path& path, const PoseGraphPlotText& text,
                        const PoseGraph& before, const PoseGraph& after,
                        const PoseGraphSummary& summary);

}  // namespace highwall::apps
