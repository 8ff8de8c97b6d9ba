#include <highwall/frontend/input/yaml_reader.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include <yaml-cpp/yaml.h>

#include <highwall/core/error.h>
#include <highwall/internal/did_you_mean.h>

namespace highwall {
namespace {

std::int64_t LineOfNode(const YAML::Node& node) {
  return std::max(node.Mark().line, 0) + 1;
}

bool IsFiniteValue(double value) {
  return std::isfinite(value);
}
template <typename T>
bool IsFiniteValue(const T&) {
  return true;
}

}  // namespace

YamlReader::YamlReader(std::filesystem::path path, std::string name, YAML::Node node)
    : path_(std::move(path)), name_(std::move(name)), node_(std::move(node)) {}

YamlReader YamlReader::Load(const std::filesystem::path& path) {
  YAML::Node node;
  if (std::filesystem::is_directory(path)) throw IoError(path, "is a folder, not a YAML file");
  try {
    node = YAML::LoadFile(path.string());
  } catch (const YAML::BadFile&) {
    throw IoError(path, "is missing or cannot be read" + DidYouMeanPath(path));
  } catch (const YAML::ParserException& error) {
    throw IoError(path, error.mark.line + 1, "is not YAML: " + error.msg);
  }
  if (!node.IsMap()) throw IoError(path, "holds no 'key: value' lines");
  return {path, "", node};
}

std::optional<YamlReader::Entry> YamlReader::Find(const std::string& key) const {
  for (const auto& entry : node_) {
    if (entry.first.IsScalar() && entry.first.Scalar() == key) {
      return Entry{LineOfNode(entry.first), entry.second};
    }
  }
  return std::nullopt;
}

template <typename T>
void YamlReader::ReadAs(const std::string& key, const char* type, T* value) {
  Read(key, type, [value](const std::string& text) {
    T result{};
    if (!ReadScalar(text, &result) || !IsFiniteValue(result)) return false;
    *value = std::move(result);
    return true;
  });
}

void YamlReader::Read(const std::string& key, double* value) {
  ReadAs(key, "a finite number", value);
}
void YamlReader::Read(const std::string& key, int* value) {
  ReadAs(key, "an integer", value);
}
void YamlReader::Read(const std::string& key, std::string* value) {
  ReadAs(key, "a word", value);
}

void YamlReader::Read(const std::string& key, const std::string& demand,
                      const std::function<bool(const std::string&)>& parse) {
  known_.push_back(key);
  const std::optional<Entry> entry = Find(key);
  if (!entry) return;
  const YAML::Node& node = entry->value;
  if (node.IsScalar() && parse(node.Scalar())) return;
  const std::string found = node.IsScalar() ? "'" + node.Scalar() + "'" : "no single value";
  throw IoError(path_, entry->line, "'" + key + "' must be " + demand + ", found " + found);
}

void YamlReader::Read(const std::string& key, std::span<double> values) {
  known_.push_back(key);
  const std::optional<Entry> entry = Find(key);
  if (!entry) return;
  const YAML::Node& list = entry->value;
  bool valid = list.IsSequence() && list.size() == values.size();
  std::vector<double> numbers(values.size());
  for (std::size_t i = 0; valid && i < numbers.size(); ++i) {
    valid = list[i].IsScalar() && ReadScalar(list[i].Scalar(), &numbers[i]) &&
            std::isfinite(numbers[i]);
  }
  if (!valid) {
    throw IoError(
        path_, entry->line,
        "'" + key + "' must be a list of " + std::to_string(values.size()) + " finite numbers");
  }
  std::copy(numbers.begin(), numbers.end(), values.begin());
}

std::optional<std::int64_t> YamlReader::LineOf(const std::string& section,
                                               const std::string& key) const {
  const auto named = std::ranges::find(sections_, section, &YamlReader::name_);
  const YamlReader* const reader = section.empty()            ? this
                                   : named == sections_.end() ? nullptr
                                                              : &*named;
  const std::optional<Entry> entry = reader == nullptr ? std::nullopt : reader->Find(key);
  return entry ? std::optional(entry->line) : std::nullopt;
}

YamlReader& YamlReader::Section(const std::string& key) {
  const auto known = std::ranges::find(sections_, key, &YamlReader::name_);
  if (known != sections_.end()) return *known;
  known_.push_back(key);
  const std::optional<Entry> entry = Find(key);
  if (entry && !entry->value.IsMap()) {
    throw IoError(path_, entry->line, "'" + key + "' must be a section of 'key: value' lines");
  }
  sections_.push_back(YamlReader(path_, key, entry ? entry->value : YAML::Node()));
  return sections_.back();
}

void YamlReader::Refuse(const std::string& key, const std::string& message) const {
  const std::optional<Entry> entry = Find(key);
  throw IoError(path_, entry ? entry->line : 1, message);
}

void YamlReader::CheckKeys() const {
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    const std::int64_t line = LineOfNode(entry.first);
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
      throw IoError(path_, line, "unknown key '" + key + "'" + DidYouMean(key, known_));
    }
    if (!seen.insert(key).second) throw IoError(path_, line, "key '" + key + "' is there twice");
  }
}

void YamlReader::Finish() const {
  // This order reports a misspelt key before the missing key that it causes.
  CheckKeys();
  for (const YamlReader& section : sections_) section.Finish();
  for (const std::string& key : required_) {
    if (Find(key)) continue;
    throw IoError(path_, "key '" + key + "' is missing" +
                             (name_.empty() ? "" : " from section '" + name_ + "'"));
  }
}

}  // namespace highwall
