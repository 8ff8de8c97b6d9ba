#pragma once

#include <string>
#include <vector>

#include "sweep_tables.h"

// Tables 1, 2 and 4 of the paper in its layout, its own figures beside ours (docs/paper.md).
namespace highwall::bench {

// Points alone, points and lines, each with the map of the default; and all that has a switch as
// the paper has it, with the map of its depths.
std::vector<NamedSetting> PaperSettings();

// "fr2_desk" of "rgbd_dataset_freiburg2_desk": as the paper's figures are listed.
std::string PaperNameOf(const std::string& sequence);

// Rows of PaperSettings(), in Markdown; figures are medians over the runs.
std::string PaperTables(const std::vector<SweepRow>& rows);

}  // namespace highwall::bench
