#include "input/foreign_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

namespace highwall {
namespace {

std::int64_t LineOfMark(const YAML::Mark& mark) {
  return std::max(mark.line, 0) + 1;
}

ForeignMap::Members MembersOf(const YAML::Node& node) {
  ForeignMap::Members members;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) continue;
    members.insert_or_assign(entry.first.Scalar(),
                             ForeignMap::Member{LineOfMark(entry.first.Mark()), entry.second});
  }
  return members;
}

// Empty unless the node is one finite number.
std::optional<double> NumberOf(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  const std::optional<double> number = ReadNumber<double>(node.Scalar());
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// Empty unless the node is a list of `count` finite numbers, or of any number of them if it is 0.
std::optional<std::vector<double>> NumbersOf(const YAML::Node& node, std::size_t count) {
  if (!node.IsSequence() || (count > 0 && node.size() != count)) return std::nullopt;
  std::vector<double> numbers;
  for (const YAML::Node& element : node) {
    const std::optional<double> number = NumberOf(element);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<Stamp> SecondsOf(const YAML::Node& node) {
  return node.IsScalar() ? ParseStamp(node.Scalar()) : std::nullopt;
}

std::string ListOf(std::size_t count) {
  return "a list of " + (count > 0 ? std::to_string(count) + " " : "") + "finite numbers";
}

}  // namespace

// JSON is read as the subset of YAML that it is.
ForeignMap ForeignMap::LoadJson(const std::filesystem::path& path) {
  return Parse(path, ReadTextFile(path), "JSON");
}

ForeignMap ForeignMap::Parse(const std::filesystem::path& path, const std::string& text,
                             const std::string& language) {
  YAML::Node node;
  try {
    node = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw IoError(path, LineOfMark(error.mark), "is not " + language + ": " + error.msg);
  }
  if (!node.IsMap()) {
    throw IoError(path,
                  language == "JSON" ? "is not a JSON object" : "holds no 'key: value' lines");
  }
  return {path, MembersOf(node)};
}

const ForeignMap::Member& ForeignMap::At(const std::string& key) const {
  const auto found = members_.find(key);
  if (found != members_.end()) return found->second;
  if (name_.empty()) throw IoError(path_, "has no '" + key + "'");
  throw IoError(path_, line_, "'" + name_ + "' has no '" + key + "'");
}

void ForeignMap::Refuse(const std::string& key, const std::string& demand) const {
  Fail(key, "'" + key + "' must be " + demand);
}

void ForeignMap::Fail(const std::string& key, const std::string& message) const {
  throw IoError(path_, At(key).line, message);
}

double ForeignMap::Number(const std::string& key) const {
  const std::optional<double> number = NumberOf(At(key).value);
  if (!number) Refuse(key, "a finite number");
  return *number;
}

int ForeignMap::Integer(const std::string& key) const {
  const double number = Number(key);
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max()) {
    Refuse(key, "a whole number");
  }
  return static_cast<int>(number);
}

std::string ForeignMap::Word(const std::string& key) const {
  const YAML::Node& value = At(key).value;
  if (!value.IsScalar()) Refuse(key, "a word");
  return value.Scalar();
}

Stamp ForeignMap::Seconds(const std::string& key) const {
  const std::optional<Stamp> stamp = SecondsOf(At(key).value);
  if (!stamp) Refuse(key, "a time in seconds");
  return *stamp;
}

std::vector<Stamp> ForeignMap::SecondsList(const std::string& key) const {
  const YAML::Node& list = At(key).value;
  std::vector<Stamp> stamps;
  if (list.IsSequence()) {
    for (const YAML::Node& element : list) {
      if (const std::optional<Stamp> stamp = SecondsOf(element)) stamps.push_back(*stamp);
    }
  }
  if (!list.IsSequence() || stamps.size() != list.size()) Refuse(key, "a list of times in seconds");
  return stamps;
}

std::vector<double> ForeignMap::Numbers(const std::string& key, std::size_t count) const {
  std::optional<std::vector<double>> numbers = NumbersOf(At(key).value, count);
  if (!numbers) Refuse(key, ListOf(count));
  return *std::move(numbers);
}

std::vector<std::vector<double>> ForeignMap::Rows(const std::string& key, std::size_t count) const {
  const YAML::Node& list = At(key).value;
  if (!list.IsSequence()) Refuse(key, "a list of lists");
  std::vector<std::vector<double>> rows;
  for (const YAML::Node& element : list) {
    std::optional<std::vector<double>> row = NumbersOf(element, count);
    if (!row) {
      throw IoError(path_, LineOfMark(element.Mark()),
                    "each element of '" + key + "' must be " + ListOf(count));
    }
    rows.push_back(*std::move(row));
  }
  return rows;
}

std::vector<double> ForeignMap::Matrix(const std::string& key, std::size_t count) const {
  const YAML::Node& value = At(key).value;
  if (!value.IsMap()) return Numbers(key, count);
  const YAML::Node data = value["data"];
  std::optional<std::vector<double>> numbers = data ? NumbersOf(data, count) : std::nullopt;
  if (!numbers) Refuse(key, "a matrix whose data is " + ListOf(count));
  return *std::move(numbers);
}

ForeignMap ForeignMap::Map(const std::string& key) const {
  const Member& member = At(key);
  if (!member.value.IsMap()) Refuse(key, "a section of 'key: value' lines");
  return {path_, MembersOf(member.value), key, member.line};
}

}  // namespace highwall
