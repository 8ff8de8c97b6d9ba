#pragma once

#include <string>
#include <vector>

#include "sweep_tables.h"

// Tables 1, 2 and 4 of the paper in its layout, with its own figures next to ours (docs/reference/paper.md).
namespace highwall::bench {

// Returns the settings: points only, points and lines, each with the default map; and all
// switchable options as in the paper, with a map of its depth range.
std::vector<NamedSetting> PaperSettings();

// Returns "fr2_desk" for "rgbd_dataset_freiburg2_desk": the name in the paper's tables.
std::string PaperNameOf(const std::string& sequence);

// Returns a Markdown table of rows of PaperSettings(); figures are medians over the runs.
std::string PaperTables(const std::vector<SweepRow>& rows);

}  // namespace highwall::bench
