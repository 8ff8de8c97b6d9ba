#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

// The images of a run whose colour was taken before their stamps: by the time at which it was
// taken, which is the stamp of the keyframe and of the depth that belong to it.
using LateColour = std::map<Stamp, Stamp>;

nlohmann::json ToJson(const LateColour& late);
// Reads it from a run.json; empty if that has none. Throws IoError if it cannot be read.
LateColour ReadLateColour(const std::filesystem::path& run_json);

// Returns the index of the image with the colour of the time `stamp`; empty if none is late to it.
std::optional<std::size_t> ImageOfColour(const LateColour& late, const Dataset& dataset,
                                         Stamp stamp);

}  // namespace highwall::apps
