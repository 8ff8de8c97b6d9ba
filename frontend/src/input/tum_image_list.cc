#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

#include "input/tum_associations.h"

namespace highwall {
namespace {

// One entry of a list, unparsed.
struct ListedImage {
  std::int64_t line = 0;
  std::string stamp, name;
};

// Removes the next field from the front of the line and returns it; empty at the end.
std::string_view NextField(std::string_view* line, std::string_view between) {
  const std::size_t begin = std::min(line->find_first_not_of(between), line->size());
  const std::size_t end = std::min(line->find_first_of(between, begin), line->size());
  const std::string_view field = line->substr(begin, end - begin);
  line->remove_prefix(end);
  return field;
}

// Returns the separators behind a stamp: blanks, or else the separator of the line, since a file
// name may contain a comma.
std::string_view Between(std::string_view behind_stamp) {
  if (behind_stamp.starts_with(',')) return " \t\r,";
  if (behind_stamp.starts_with(';')) return " \t\r;";
  return " \t\r";
}

// Parses "1,5" followed by a blank or a semicolon: the fraction of a stamp with a decimal comma.
std::string_view DecimalsBehind(std::string_view* line) {
  if (!line->starts_with(',')) return {};
  const std::size_t end = std::min(line->find_first_not_of("0123456789", 1), line->size());
  const bool decimals = end > 1 && end < line->size() && (*line)[end] != ',' &&
                        std::string_view(" \t;").find((*line)[end]) != std::string_view::npos;
  const std::string_view digits = decimals ? line->substr(1, end - 1) : std::string_view();
  if (decimals) line->remove_prefix(end);
  return digits;
}

// Returns whether a first line holds column names without a leading #, which would make it a
// comment.
bool IsListHeading(std::string_view line) {
  if (line.find_first_of("./\\") != std::string_view::npos) return false;  // names a file
  const std::string_view first = NextField(&line, " \t\r,;");
  const std::string_view second = NextField(&line, " \t\r,;");
  return !second.empty() && std::isalpha(static_cast<unsigned char>(first.front())) != 0;
}

// Reads up to `pairs` pairs of stamp and name from each line that is no comment.
std::vector<std::vector<ListedImage>> ReadPairs(const std::filesystem::path& list,
                                                std::size_t pairs) {
  TextReader text(ReadTextFile(list));
  std::vector<std::vector<ListedImage>> columns(pairs);
  bool first = true;
  std::string content;
  for (std::int64_t number = 1; std::getline(text, content); ++number) {
    std::string_view line = content;
    if (!line.starts_with('#') && std::exchange(first, false) && IsListHeading(line)) continue;
    for (std::size_t i = 0; i < pairs; ++i) {
      std::string stamp(NextField(&line, " \t\r,;"));
      if (i == 0 && (stamp.empty() || stamp.front() == '#')) break;
      const std::string_view decimals = DecimalsBehind(&line);
      if (!decimals.empty()) stamp.append(".").append(decimals);
      const std::string_view name = NextField(&line, Between(line));
      if (name.empty() && !ParseStamp(stamp)) {
        throw IoError(list, number, "'" + stamp + "' is not a time stamp in seconds");
      }
      if (name.empty()) throw IoError(list, number, "a file name is missing behind the stamp");
      columns[i].push_back({number, stamp, std::string(name)});
    }
  }
  return columns;
}

// A unit of integer stamps.
struct ListUnit {
  const char* name;
  std::int64_t nanoseconds;
};
constexpr std::array<ListUnit, 4> kListUnits{ListUnit{"seconds", 1'000'000'000},
                                             {"milliseconds", 1'000'000},
                                             {"microseconds", 1'000},
                                             {"nanoseconds", 1}};

std::optional<std::int64_t> ParseWholeStamp(std::string_view text) {
  constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 2;
  std::int64_t value = 0;
  return ParseNumber(text, &value) && value >= -kLatest && value <= kLatest ? std::optional(value)
                                                                            : std::nullopt;
}

// Returns the stamps, sorted, if all are whole numbers; else nothing.
std::vector<std::int64_t> WholeStamps(const std::vector<ListedImage>& images) {
  std::vector<std::int64_t> values;
  for (const ListedImage& image : images) {
    const std::optional<std::int64_t> value = ParseWholeStamp(image.stamp);
    if (!value) return {};
    values.push_back(*value);
  }
  std::ranges::sort(values);
  return values;
}

// Determines the unit from the time between two images, which is 5 ms to 5 s in one unit only; for
// a single image, from the years since 1970.
const ListUnit& UnitOf(const std::vector<std::int64_t>& stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) steps.push_back(static_cast<double>(stamps[i] - stamps[i - 1]));
  }
  const double value = steps.empty() ? static_cast<double>(stamps.back()) : UpperMedian(steps);
  const double limit = steps.empty() ? 1e11 : 5.0;  // lowest value that is not in seconds
  if (value < limit) return kListUnits[0];
  const auto larger = static_cast<std::size_t>(std::log10(value / limit) / 3.0);
  return kListUnits[std::min<std::size_t>(1 + larger, 3)];
}

// Returns the unit of a list whose stamps are whole numbers not in seconds, with a warning.
const ListUnit* FindListUnit(const std::filesystem::path& list,
                             const std::vector<ListedImage>& images,
                             std::vector<std::string>* warnings) {
  const std::vector<std::int64_t> stamps = WholeStamps(images);
  if (stamps.empty()) return nullptr;
  const ListUnit& unit = UnitOf(stamps);
  if (&unit == &kListUnits[0]) return nullptr;
  // A stamp that is too large for its unit is invalid.
  const std::int64_t limit = std::numeric_limits<std::int64_t>::max() / 2 / unit.nanoseconds;
  if (stamps.back() > limit || stamps.front() < -limit) return nullptr;
  warnings->push_back(list.string() + ": its stamps are in " + unit.name +
                      ", not in seconds; converted");
  return &unit;
}

// Returns the path in the folder of the list; back-slashes of a list from Windows are converted.
std::filesystem::path Located(const std::filesystem::path& list, std::string name) {
  const std::filesystem::path path = list.parent_path() / name;
  std::error_code error;
  if (name.find('\\') == std::string::npos || std::filesystem::exists(path, error)) return path;
  std::ranges::replace(name, '\\', '/');
  return list.parent_path() / name;
}

// Sorts by stamp and removes duplicates.
void PutInOrder(const std::filesystem::path& list, const std::vector<ListedImage>& images,
                std::vector<std::pair<Stamp, std::size_t>>* order,
                std::vector<std::string>* warnings) {
  const auto where = [&](std::size_t image) {
    return list.string() + ":" + std::to_string(images[image].line) + ": stamp " +
           images[image].stamp;
  };
  const auto back = std::adjacent_find(order->begin(), order->end(),
                                       [](const auto& a, const auto& b) { return b < a; });
  if (back != order->end()) {
    warnings->push_back(where(std::next(back)->second) +
                        " is smaller than the one before; the list is sorted");
    std::ranges::sort(*order);
  }
  std::optional<std::size_t> first;
  std::size_t doubled = 0;
  for (std::size_t i = 1; i < order->size(); ++i) {
    if ((*order)[i].first != (*order)[i - 1].first) continue;
    if (!first) first = (*order)[i].second;
    ++doubled;
  }
  if (!first) return;
  // One in ten is a glitch of the recorder; more means that stamps no longer distinguish images.
  if (doubled > std::max<std::size_t>(1, order->size() / 10)) {
    throw IoError(list, images[*first].line,
                  "stamp " + images[*first].stamp + " is there twice, one of " +
                      std::to_string(doubled) +
                      " such lines: give each image a stamp of its own, with enough decimals");
  }
  warnings->push_back(where(*first) + " is there twice; the first line stays");
  const auto end = std::unique(order->begin(), order->end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; });
  order->erase(end, order->end());
}

std::vector<TumImageFile> ToFiles(const std::filesystem::path& list,
                                  const std::vector<ListedImage>& images,
                                  std::vector<std::string>* warnings) {
  if (images.empty()) throw IoError(list, "lists no image");
  const ListUnit* const unit = FindListUnit(list, images, warnings);
  std::vector<std::pair<Stamp, std::size_t>> order;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::optional<Stamp> stamp =
        unit ? std::optional(ParseWholeStamp(images[i].stamp).value() * unit->nanoseconds)
             : ParseStamp(images[i].stamp);
    if (!stamp) {
      throw IoError(list, images[i].line,
                    "'" + images[i].stamp + "' is not a time stamp in seconds");
    }
    order.emplace_back(*stamp, i);
  }
  PutInOrder(list, images, &order, warnings);
  std::vector<TumImageFile> files;
  for (const auto& [stamp, i] : order) files.push_back({stamp, Located(list, images[i].name)});
  return files;
}

bool NamesDepth(const ListedImage& image) {
  return image.name.find("depth") != std::string::npos;
}

}  // namespace

std::vector<TumImageFile> ReadTumImageList(const std::filesystem::path& list,
                                           std::vector<std::string>* warnings) {
  std::vector<std::string> unheard;
  return ToFiles(list, ReadPairs(list, 1).front(), warnings != nullptr ? warnings : &unheard);
}

std::optional<std::filesystem::path> FindTumAssociations(const std::filesystem::path& directory) {
  std::error_code error;
  for (const char* name :
       {"associations.txt", "association.txt", "associated.txt", "associate.txt", "assoc.txt"}) {
    if (std::filesystem::is_regular_file(directory / name, error)) return directory / name;
  }
  return std::nullopt;
}

TumAssociations ReadTumAssociations(const std::filesystem::path& list,
                                    std::vector<std::string>* warnings) {
  auto columns = ReadPairs(list, 2);
  if (!columns[0].empty() && NamesDepth(columns[0].front()) && !NamesDepth(columns[1].front())) {
    std::swap(columns[0], columns[1]);
  }
  return {ToFiles(list, columns[0], warnings), ToFiles(list, columns[1], warnings)};
}

}  // namespace highwall
