#include "input/numbered_pairs_dataset.h"

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string_view>

#include "input/numbered_files.h"
#include "input/numbered_frames.h"

namespace highwall {
namespace {

using NumberedImages = std::map<std::int64_t, std::filesystem::path>;

// The images of the first of these folders that has any.
NumberedImages ImagesOfFirst(const std::filesystem::path& folder,
                             std::initializer_list<const char*> names,
                             std::initializer_list<std::string_view> suffixes) {
  for (const char* const name : names) {
    NumberedImages images = NumberedFiles(folder / name, "", suffixes);
    if (!images.empty()) return images;
  }
  return {};
}

NumberedImages ColourOfPairs(const std::filesystem::path& folder) {
  return ImagesOfFirst(folder, {"color", "rgb_png", "rgb", "image"},
                       {".png", ".jpg", ".jpeg", ".ppm"});
}

NumberedImages DepthOfPairs(const std::filesystem::path& folder) {
  return ImagesOfFirst(folder, {"depth", "depth_png"}, {".png", ".pgm"});
}

FrameList ReadNumberedPairs(const std::filesystem::path& folder, const DatasetOptions& options) {
  FrameList list = PairNumberedImages(folder, ColourOfPairs(folder), DepthOfPairs(folder), options);
  list.imu_file = FindImuFile(folder);
  return list;
}

}  // namespace

bool NumberedPairsDataset::IsOne(const std::filesystem::path& folder) {
  return !ColourOfPairs(folder).empty() && !DepthOfPairs(folder).empty();
}

NumberedPairsDataset::NumberedPairsDataset(const std::filesystem::path& folder,
                                           const std::optional<RgbdSensor>& sensor,
                                           const DatasetOptions& options)
    : FrameListDataset(folder, ReadNumberedPairs(folder, options), sensor, options) {}

}  // namespace highwall
