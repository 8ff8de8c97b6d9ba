#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include <highwall/core/stamp.h>

namespace highwall {

// The members of a JSON or YAML file that another program writes. Unknown members are ignored. All
// errors are IoErrors naming the file, the line and the member.
class ForeignMap {
 public:
  struct Member {
    std::int64_t line = 0;  // counted from 1
    YAML::Node value;
  };
  using Members = std::map<std::string, Member>;

  // Throws if the file is unreadable, is not JSON, or has no object at its top.
  static ForeignMap LoadJson(const std::filesystem::path& path);
  // text: of the file at `path`; language: "JSON" or "YAML", for messages. Throws as above.
  static ForeignMap Parse(const std::filesystem::path& path, const std::string& text,
                          const std::string& language);
  // name, line: of a map that is a member itself; empty and 0 for the file.
  ForeignMap(std::filesystem::path path, Members members, std::string name = "",
             std::int64_t line = 0)
      : path_(std::move(path)), members_(std::move(members)), name_(std::move(name)), line_(line) {}

  const std::filesystem::path& path() const { return path_; }
  bool Has(const std::string& key) const { return members_.contains(key); }

  // Each throws if the member is missing or of another form; numbers are finite.
  double Number(const std::string& key) const;
  int Integer(const std::string& key) const;
  std::string Word(const std::string& key) const;
  // A time [s], converted without rounding.
  Stamp Seconds(const std::string& key) const;
  std::vector<Stamp> SecondsList(const std::string& key) const;
  // count: the number of elements; 0: any number.
  std::vector<double> Numbers(const std::string& key, std::size_t count) const;
  // A list of lists of `count` numbers each.
  std::vector<std::vector<double>> Rows(const std::string& key, std::size_t count) const;
  // The numbers of a matrix, row by row, that is written as a list or as a map {rows, cols, data}
  // of OpenCV and ROS. count: as in Numbers().
  std::vector<double> Matrix(const std::string& key, std::size_t count) const;
  // A map under a key.
  ForeignMap Map(const std::string& key) const;

  // Throws that the member must be as demanded.
  [[noreturn]] void Refuse(const std::string& key, const std::string& demand) const;
  // Throws this message, with the line of the member.
  [[noreturn]] void Fail(const std::string& key, const std::string& message) const;

 private:
  const Member& At(const std::string& key) const;

  std::filesystem::path path_;
  Members members_;
  std::string name_;
  std::int64_t line_;
};

}  // namespace highwall
