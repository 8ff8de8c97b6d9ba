#include <highwall/internal/did_you_mean.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <system_error>

namespace highwall {
namespace {

// Returns the most similar known word, if it is similar enough.
std::optional<std::string> Nearest(const std::string& word, const std::vector<std::string>& known) {
  if (known.empty()) return std::nullopt;
  const auto distance = [&](const std::string& other) {
    const bool begins = word.size() >= 3 && other.starts_with(word);
    return begins ? 1 : EditDistance(word, other);
  };
  const std::string& nearest = *std::ranges::min_element(known, {}, distance);
  // A third of the letters may differ.
  if (distance(nearest) > std::max<std::size_t>(1, nearest.size() / 3)) return std::nullopt;
  return nearest;
}

std::string Ask(const std::string& meant) {
  return "; did you mean '" + meant + "'?";
}

}  // namespace

std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  const std::optional<std::string> nearest = Nearest(word, known);
  return nearest ? Ask(*nearest) : "";
}

std::string DidYouMeanPath(const std::filesystem::path& path) {
  const std::filesystem::path place = path.has_filename() ? path : path.parent_path();
  const std::filesystem::path folder = place.parent_path();
  std::error_code error;
  std::vector<std::string> known;
  std::filesystem::directory_iterator entries(folder.empty() ? "." : folder, error);
  for (; !error && entries != std::filesystem::directory_iterator(); entries.increment(error)) {
    known.push_back(entries->path().filename().string());
  }
  std::ranges::sort(known);
  const std::optional<std::string> name = Nearest(place.filename().string(), known);
  return name ? Ask((folder / *name).string()) : "";
}

}  // namespace highwall
