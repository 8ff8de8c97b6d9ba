#include "input/json_object.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

namespace highwall {
namespace {

std::int64_t LineOfJson(const YAML::Mark& mark) {
  return std::max(mark.line, 0) + 1;
}

// Empty unless the node is one finite number.
std::optional<double> JsonNumber(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  const std::optional<double> number = ReadNumber<double>(node.Scalar());
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// Empty unless the node is a list of `count` finite numbers, or of any number of them if it is 0.
std::optional<std::vector<double>> JsonNumbers(const YAML::Node& node, std::size_t count) {
  if (!node.IsSequence() || (count > 0 && node.size() != count)) return std::nullopt;
  std::vector<double> numbers;
  for (const YAML::Node& element : node) {
    const std::optional<double> number = JsonNumber(element);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<Stamp> JsonSeconds(const YAML::Node& node) {
  return node.IsScalar() ? ParseStamp(node.Scalar()) : std::nullopt;
}

std::string ListOf(std::size_t count) {
  return "a list of " + (count > 0 ? std::to_string(count) + " " : "") + "finite numbers";
}

}  // namespace

// JSON is read as the subset of YAML that it is.
JsonObject JsonObject::Load(const std::filesystem::path& path) {
  JsonObject object;
  object.path_ = path;
  YAML::Node node;
  try {
    node = YAML::Load(ReadTextFile(path));
  } catch (const YAML::Exception& error) {
    throw IoError(path, LineOfJson(error.mark), "is not JSON: " + error.msg);
  }
  if (!node.IsMap()) throw IoError(path, "is not a JSON object");
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) continue;
    object.members_.insert_or_assign(entry.first.Scalar(),
                                     Member{LineOfJson(entry.first.Mark()), entry.second});
  }
  return object;
}

const JsonObject::Member& JsonObject::At(const std::string& key) const {
  const auto found = members_.find(key);
  if (found == members_.end()) throw IoError(path_, "has no '" + key + "'");
  return found->second;
}

void JsonObject::Refuse(const std::string& key, const std::string& demand) const {
  throw IoError(path_, At(key).line, "'" + key + "' must be " + demand);
}

double JsonObject::Number(const std::string& key) const {
  const std::optional<double> number = JsonNumber(At(key).value);
  if (!number) Refuse(key, "a finite number");
  return *number;
}

int JsonObject::Integer(const std::string& key) const {
  const double number = Number(key);
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max()) {
    Refuse(key, "a whole number");
  }
  return static_cast<int>(number);
}

Stamp JsonObject::Seconds(const std::string& key) const {
  const std::optional<Stamp> stamp = JsonSeconds(At(key).value);
  if (!stamp) Refuse(key, "a time in seconds");
  return *stamp;
}

std::vector<Stamp> JsonObject::SecondsList(const std::string& key) const {
  const YAML::Node& list = At(key).value;
  std::vector<Stamp> stamps;
  if (list.IsSequence()) {
    for (const YAML::Node& element : list) {
      if (const std::optional<Stamp> stamp = JsonSeconds(element)) stamps.push_back(*stamp);
    }
  }
  if (!list.IsSequence() || stamps.size() != list.size()) Refuse(key, "a list of times in seconds");
  return stamps;
}

std::vector<double> JsonObject::Numbers(const std::string& key, std::size_t count) const {
  std::optional<std::vector<double>> numbers = JsonNumbers(At(key).value, count);
  if (!numbers) Refuse(key, ListOf(count));
  return *std::move(numbers);
}

std::vector<std::vector<double>> JsonObject::Rows(const std::string& key, std::size_t count) const {
  const YAML::Node& list = At(key).value;
  if (!list.IsSequence()) Refuse(key, "a list of lists");
  std::vector<std::vector<double>> rows;
  for (const YAML::Node& element : list) {
    std::optional<std::vector<double>> row = JsonNumbers(element, count);
    if (!row) {
      throw IoError(path_, LineOfJson(element.Mark()),
                    "each element of '" + key + "' must be " + ListOf(count));
    }
    rows.push_back(*std::move(row));
  }
  return rows;
}

}  // namespace highwall
