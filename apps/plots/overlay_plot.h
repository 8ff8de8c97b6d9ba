#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// Error of an estimate, with its name.
struct NamedError {
  std::string name;
  TrajectoryError error;
};

struct OverlayText {
  std::string title, subtitle;
  std::string quantity;  // including its unit
};

// Writes an SVG or PNG with two panels. Left: the reference in grey and all estimates. Right: their
// errors over time, starting at the first matched stamp of all estimates. Each estimate has its own
// colour and dash pattern. Throws IoError.
void WriteOverlayPlot(const std::filesystem::path& path, const OverlayText& text,
                      const Trajectory& reference, const std::vector<NamedError>& estimates);

}  // namespace highwall::apps
