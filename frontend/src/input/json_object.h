#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include <highwall/core/stamp.h>

namespace highwall {

// The members of a JSON file that recording programs write. Unknown members are ignored. All errors
// are IoErrors naming the file, the line and the member.
class JsonObject {
 public:
  // Throws if the file is unreadable, is not JSON, or has no object at its top.
  static JsonObject Load(const std::filesystem::path& path);

  bool Has(const std::string& key) const { return members_.contains(key); }
  // Each throws if the member is missing or of another form; numbers are finite.
  double Number(const std::string& key) const;
  int Integer(const std::string& key) const;
  // A time [s], converted without rounding.
  Stamp Seconds(const std::string& key) const;
  std::vector<Stamp> SecondsList(const std::string& key) const;
  // count: the number of elements; 0: any number.
  std::vector<double> Numbers(const std::string& key, std::size_t count) const;
  // A list of lists of `count` numbers each.
  std::vector<std::vector<double>> Rows(const std::string& key, std::size_t count) const;

 private:
  struct Member {
    std::int64_t line = 0;  // counted from 1
    YAML::Node value;
  };

  const Member& At(const std::string& key) const;
  [[noreturn]] void Refuse(const std::string& key, const std::string& demand) const;

  std::filesystem::path path_;
  std::map<std::string, Member> members_;
};

}  // namespace highwall
