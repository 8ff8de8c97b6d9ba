#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/input/tum_dataset.h>

namespace highwall {

// Colour and depth images of a recording listed in one file, in the order of their stamps.
struct TumAssociations {
  std::vector<TumImageFile> colour, depth;
};

// Returns the path of associations.txt, as TUM's associate.py writes it for other systems, under
// one of its usual names.
std::optional<std::filesystem::path> FindTumAssociations(const std::filesystem::path& directory);

// Reads "stamp path stamp path" per line, colour or depth first. Throws IoError and warns as
// ReadTumImageList().
TumAssociations ReadTumAssociations(const std::filesystem::path& list,
                                    std::vector<std::string>* warnings);

}  // namespace highwall
