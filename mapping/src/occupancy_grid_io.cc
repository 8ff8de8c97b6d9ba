#include <cctype>
#include <string>
#include <string_view>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/mapping/occupancy_grid.h>

namespace highwall {
namespace {

// Returns a YAML scalar, in single quotes unless every parser takes the text for a plain string.
std::string Quoted(const std::string& text) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  const bool letter_first = !text.empty() && std::isalpha(static_cast<unsigned char>(text[0]));
  if (letter_first && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

char Pixel(GridCell cell) {
  switch (cell) {
    case GridCell::kOccupied:
      return static_cast<char>(0);
    case GridCell::kFree:
      return static_cast<char>(254);
    case GridCell::kUnknown:
      break;
  }
  return static_cast<char>(205);
}

}  // namespace

void WriteOccupancyGrid(const std::filesystem::path& yaml_path, const OccupancyGrid& grid) {
  HIGHWALL_REQUIRE(grid.width > 0 && grid.height > 0, "the grid is empty");
  HIGHWALL_REQUIRE(yaml_path.extension() != ".pgm", "give the name of the YAML file");
  std::filesystem::path pgm_path = yaml_path;
  pgm_path.replace_extension(".pgm");

  AtomicFile pgm(pgm_path);
  pgm.stream() << "P5\n"
               << std::to_string(grid.width) << ' ' << std::to_string(grid.height) << "\n255\n";
  for (int j = grid.height - 1; j >= 0; --j) {
    for (int i = 0; i < grid.width; ++i) pgm.stream().put(Pixel(grid.At(i, j)));
  }
  AtomicFile yaml(yaml_path);
  yaml.stream() << "image: " << Quoted(pgm_path.filename().string())
                << "\nmode: trinary\nresolution: " << NumberText(grid.resolution) << "\norigin: ["
                << NumberText(grid.origin_G.x()) << ", " << NumberText(grid.origin_G.y())
                << ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  // The image is committed first, so that a YAML file never refers to a missing image.
  pgm.Commit();
  yaml.Commit();
}

}  // namespace highwall
