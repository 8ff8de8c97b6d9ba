#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

// What distinguishes a recording from another in a folder of the same name. It does not depend on
// the calibration, nor on how colour and depth are paired.
struct RecordingIdentity {
  std::size_t colour_images = 0;
  Stamp first = 0, last = 0;  // of the colour images
  // FNV-1a hash of the bytes of the first colour image, 16 digits; empty for a recording without a
  // list of its images, and for an image that cannot be read.
  std::string first_image;
};

// Returns the identity of a dataset with at least one frame.
RecordingIdentity IdentityOf(const Dataset& dataset);
nlohmann::json ToJson(const RecordingIdentity& identity);

// Returns how a dataset differs from the one of a run with this run.json: "has 30 colour images,
// that of the run had 40"; empty if it does not, or if an older version wrote the run.
std::string DifferenceFromRun(const Dataset& dataset, const nlohmann::json& report);
// Returns the same for the recording in a folder; empty if it cannot be opened.
std::string DifferenceFromRun(const std::filesystem::path& folder, const nlohmann::json& report);

// Throws IoError naming `folder` if its dataset is not the one of the run in the folder `run`.
void RequireRecordingOfRun(const std::filesystem::path& folder, const Dataset& dataset,
                           const std::filesystem::path& run);

}  // namespace highwall::apps
