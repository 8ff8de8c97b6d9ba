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
  // Residual of each error after known causes (ErrorExplanation::left), also drawn; may be empty.
  std::vector<double> left{};
};

// Writes an SVG with two panels. Left: both trajectories viewed along the axis of least extent, the
// whole reference in grey, the matched and aligned estimate coloured by its error. Right: the error
// over time with its mean and root mean square. Throws IoError.
void WriteErrorPlot(const std::filesystem::path& path, const ErrorPlotText& text,
                    const Trajectory& reference, const TrajectoryError& result);

}  // namespace highwall::apps
