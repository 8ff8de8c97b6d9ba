#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include <highwall/internal/number_text.h>

namespace highwall::apps {

// What the text of a scalar says, the same under every locale: yaml-cpp reads numbers by streams.
// False where it is no T.
template <typename T>
bool ReadScalar(const std::string& text, T* value) {
  if constexpr (std::integral<T> && !std::same_as<T, bool>) {
    const std::optional<T> number = ReadNumber<T>(text);
    if (number) *value = *number;
    return number.has_value();
  } else if constexpr (std::floating_point<T>) {
    if (const std::optional<T> number = ReadNumber<T>(text); number && std::isfinite(*number)) {
      *value = *number;
      return true;
    }
    return YAML::convert<T>::decode(YAML::Node(text), *value) && !std::isfinite(*value);  // ".inf"
  } else {
    return YAML::convert<T>::decode(YAML::Node(text), *value);
  }
}

// One map of a YAML file, read key by key. Every key that is asked for becomes known; Finish() then
// refuses whatever else the map holds, so that a misspelt option is never ignored:
//
//   YamlReader file = YamlReader::Load(path);
//   file.Read("depth_factor", &depth_factor);     // one line for each option
//   file.Finish();
//
// All errors are IoErrors naming the file, the line and the key.
class YamlReader {
 public:
  // Throws if the file cannot be read, is not YAML, or holds no map at its top.
  static YamlReader Load(const std::filesystem::path& path);

  // The value keeps its default where the key is absent. Throws for a value of another type; a
  // double must be finite.
  void Read(const std::string& key, double* value);
  void Read(const std::string& key, int* value);
  void Read(const std::string& key, bool* value);
  void Read(const std::string& key, std::string* value);
  // A list of as many finite numbers as `values` has room for.
  void Read(const std::string& key, std::span<double> values);
  // A single value that `parse` takes; demand: what it must be, for people. Throws where parse
  // returns false.
  void Read(const std::string& key, const std::string& demand,
            const std::function<bool(const std::string&)>& parse);
  // As Read, but Finish() throws if the key is absent.
  template <typename T>
  void Require(const std::string& key, T* value) {
    Read(key, value);
    required_.push_back(key);
  }
  bool Has(const std::string& key) const { return Find(key).has_value(); }
  // Of a key of a section, itself if `section` is empty; counted from 1, empty where it is absent.
  std::optional<std::int64_t> LineOf(const std::string& section, const std::string& key) const;
  // The map under `key`, an empty one where absent; valid as long as this reader. Throws if it is
  // no map.
  YamlReader& Section(const std::string& key);

  // Throws for an unknown key, naming the known one that may be meant, for a key that is there
  // twice, and for a required key that is missing; here and in all sections.
  void Finish() const;

 private:
  YamlReader(std::filesystem::path path, std::string name, YAML::Node node);

  struct Entry {
    std::int64_t line = 0;  // of the key, counted from 1
    YAML::Node value;
  };

  std::optional<Entry> Find(const std::string& key) const;
  template <typename T>
  void ReadAs(const std::string& key, const char* type, T* value);
  // Throws for an unknown key and one that is there twice.
  void CheckKeys() const;

  std::filesystem::path path_;
  std::string name_;  // of this section; empty for the top
  YAML::Node node_;
  std::vector<std::string> known_, required_;
  std::list<YamlReader> sections_;
};

}  // namespace highwall::apps
