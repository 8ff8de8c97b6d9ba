#include "input/numbered_files.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <system_error>

#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

// Returns the number between prefix and suffix; empty for any other name.
std::optional<std::int64_t> NumberIn(std::string_view name, std::string_view prefix,
                                     std::string_view suffix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  if (!name.ends_with(suffix)) return std::nullopt;
  name.remove_suffix(suffix.size());
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  if (name.empty() || !std::ranges::all_of(name, is_digit)) return std::nullopt;
  return ReadNumber<std::int64_t>(name);
}

// Calls visit(number, rank of the suffix, path) for each such file until it returns false.
template <class Visit>
void VisitNumbered(const std::filesystem::path& folder, std::string_view prefix,
                   std::initializer_list<std::string_view> suffixes, const Visit& visit) {
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::size_t rank = 0;
    for (const std::string_view suffix : suffixes) {
      const std::optional<std::int64_t> number = NumberIn(name, prefix, suffix);
      if (number && !visit(*number, rank, at->path())) return;
      ++rank;
    }
  }
}

}  // namespace

std::map<std::int64_t, std::filesystem::path> NumberedFiles(
    const std::filesystem::path& folder, std::string_view prefix,
    std::initializer_list<std::string_view> suffixes) {
  std::map<std::int64_t, std::filesystem::path> files;
  std::map<std::int64_t, std::size_t> ranks;
  VisitNumbered(
      folder, prefix, suffixes,
      [&](std::int64_t number, std::size_t rank, const std::filesystem::path& path) {
        const auto [at, is_new] = ranks.try_emplace(number, rank);
        // Of 7.png and 007.png the first by name, whatever order the folder has.
        if (is_new || rank < at->second || (rank == at->second && path < files.at(number))) {
          at->second = rank;
          files.insert_or_assign(number, path);
        }
        return true;
      });
  return files;
}

bool HasNumberedFile(const std::filesystem::path& folder, std::string_view prefix,
                     std::initializer_list<std::string_view> suffixes) {
  bool found = false;
  VisitNumbered(folder, prefix, suffixes,
                [&](std::int64_t, std::size_t, const std::filesystem::path&) {
                  found = true;
                  return false;
                });
  return found;
}

std::vector<Stamp> StampsOfNumbers(const std::vector<std::int64_t>& numbers, double rate) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    steps.push_back(static_cast<double>(numbers[i] - numbers[i - 1]));
  }
  const double step = steps.empty() ? 1.0 : UpperMedian(std::move(steps));
  std::vector<Stamp> stamps;
  for (const std::int64_t number : numbers) {
    stamps.push_back(FromSeconds(static_cast<double>(number - numbers.front()) / step / rate));
  }
  return stamps;
}

}  // namespace highwall
