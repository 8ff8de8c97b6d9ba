#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

namespace highwall::apps {

// The error of an estimate, and what it is called.
struct NamedError {
  std::string name;
  TrajectoryError error;
};

struct OverlayText {
  std::string title, subtitle;
  std::string quantity;  // with its unit
};

// An SVG or PNG with two panels. Left: the reference grey and all estimates over it. Right: their
// errors over time, from the first matched stamp of all on. Each estimate has a colour and dashes
// of its own. Throws IoError.
void WriteOverlayPlot(const std::filesystem::path& path, const OverlayText& text,
                      const Trajectory& reference, const std::vector<NamedError>& estimates);

}  // namespace highwall::apps
