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

namespace [[gnu::visibility("default")]] highwall {

// Parses a scalar independently of the locale: yaml-cpp reads numbers by streams. Returns false if
// it is not a T.
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

// Reader of one map of a YAML file, key by key. Every requested key becomes known; Finish() then
// rejects any other key of the map, so that a misspelt option is never ignored:
//
//   YamlReader file = YamlReader::Load(path);
//   file.Read("depth_factor", &depth_factor);     // one line for each option
//   file.Finish();
//
// All errors are IoErrors naming the file, the line and the key.
class YamlReader {
 public:
  // Throws if the file is unreadable, is not YAML, or has no map at its top.
  static YamlReader Load(const std::filesystem::path& path);

  // The value keeps its default if the key is absent. Throws for a value of another type; a double
  // must be finite.
  void Read(const std::string& key, double* value);
  void Read(const std::string& key, int* value);
  void Read(const std::string& key, std::string* value);
  // Reads a list of exactly as many finite numbers as `values` has elements.
  void Read(const std::string& key, std::span<double> values);
  // Reads a scalar that `parse` accepts; demand: human-readable requirement. Throws if parse
  // returns false.
  void Read(const std::string& key, const std::string& demand,
            const std::function<bool(const std::string&)>& parse);
  // Like Read(), but Finish() throws if the key is absent.
  template <typename T>
  void Require(const std::string& key, T* value) {
    Read(key, value);
    required_.push_back(key);
  }
  bool Has(const std::string& key) const { return Find(key).has_value(); }
  // Returns the line of a key in a section, or at the top level if `section` is empty, counted from
  // 1; empty if absent.
  std::optional<std::int64_t> LineOf(const std::string& section, const std::string& key) const;
  // Returns the map under `key`, empty if absent; valid as long as this reader, and the same one on
  // every call. Throws if it is not a map.
  YamlReader& Section(const std::string& key);
  // Throws IoError with this message at the line of a key.
  [[noreturn]] void Refuse(const std::string& key, const std::string& message) const;

  // Throws for an unknown key (suggesting a similar one), a duplicate key, and a missing required
  // key; here and in all sections.
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
  // Throws for an unknown or duplicate key.
  void CheckKeys() const;

  std::filesystem::path path_;
  std::string name_;  // of this section; empty for the top
  YAML::Node node_;
  std::vector<std::string> known_, required_;
  std::list<YamlReader> sections_;
};

}  // namespace highwall
