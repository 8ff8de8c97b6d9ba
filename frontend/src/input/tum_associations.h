#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/input/tum_dataset.h>

namespace highwall {

// Colour and depth of a recording in one list, in the order of their stamps.
struct TumAssociations {
  std::vector<TumImageFile> colour, depth;
};

// associations.txt, as TUM's associate.py writes it for other systems, under one of its usual
// names.
std::optional<std::filesystem::path> FindTumAssociations(const std::filesystem::path& directory);

// "stamp path stamp path" a line, colour or depth first. Throws IoError and warns as
// ReadTumImageList().
TumAssociations ReadTumAssociations(const std::filesystem::path& list,
                                    std::vector<std::string>* warnings);

}  // namespace highwall
