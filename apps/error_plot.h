#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

struct ErrorPlotText {
  std::string title;
  std::string subtitle;
  std::string quantity;  // such as "translation error"
  std::string unit;      // such as "m"; empty: none
  // What known causes leave of each error (ErrorExplanation::left), drawn beside; may be empty.
  std::vector<double> left{};
};

// An SVG with two panels. Left: both trajectories seen along the axis of least spread, the whole
// reference grey, the matched and aligned estimate coloured by its error. Right: the error over
// time with its mean and root mean square. Throws IoError.
void WriteErrorPlot(const std::filesystem::path& path, const ErrorPlotText& text,
                    const Trajectory& reference, const TrajectoryError& result);

}  // namespace highwall::apps
