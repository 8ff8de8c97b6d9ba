#include <highwall/frontend/features/point_extractor.h>

#include <algorithm>

#include <highwall/core/error.h>

namespace highwall {

void FeatureType::Validate() const {
  constexpr std::size_t kLongest = 64;  // limit of the map file format
  const auto is_printable = [](char c) { return c >= ' ' && c <= '~'; };
  HIGHWALL_REQUIRE(
      !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, is_printable),
      "FeatureType::name must have 1 to 64 printable ASCII characters");
  const int fewest = descriptor == DescriptorType::kFloat ? 2 : 1;
  HIGHWALL_REQUIRE(columns >= fewest && columns <= 4096,
                   "points by " + name + ": FeatureType::columns must be " +
                       std::to_string(fewest) + " to 4096, is " + std::to_string(columns));
  try {
    pyramid.Validate();
  } catch (const InvalidArgument& error) {  // passed on with the name of the extractor
    throw InvalidArgument("points by " + name + ": " + error.what());
  }
}

PointExtractor::~PointExtractor() = default;

}  // namespace highwall
