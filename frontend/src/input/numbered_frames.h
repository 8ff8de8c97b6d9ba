#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

#include <highwall/frontend/input/dataset.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// Returns the frames of a recording without lists: the colour and depth images of the same number,
// in their order, FrameFiles::number included. Numbers that are UNIX times since 2001 in
// milliseconds, microseconds or nanoseconds are the stamps, others are spaced by
// DatasetOptions::frame_rate; a warning says which. Throws InvalidArgument for bad options.
FrameList PairNumberedImages(const std::filesystem::path& folder,
                             const std::map<std::int64_t, std::filesystem::path>& colour,
                             const std::map<std::int64_t, std::filesystem::path>& depth,
                             const DatasetOptions& options);

}  // namespace highwall
