#include "medians.h"

#include <algorithm>

namespace highwall::bench {

Scores Medians(const std::vector<Scores>& runs) {
  std::map<std::string, std::vector<double>> values;
  for (const Scores& run : runs) {
    for (const auto& [name, value] : run) values[name].push_back(value);
  }
  Scores medians;
  for (auto& [name, list] : values) {
    std::sort(list.begin(), list.end());
    medians[name] = list[list.size() / 2];
  }
  return medians;
}

}  // namespace highwall::bench
