#include "medians.h"

#include <utility>

#include <highwall/internal/median.h>

namespace highwall::bench {

Scores Medians(const std::vector<Scores>& runs) {
  std::map<std::string, std::vector<double>> values;
  for (const Scores& run : runs) {
    for (const auto& [name, value] : run) values[name].push_back(value);
  }
  Scores medians;
  for (auto& [name, list] : values) medians[name] = UpperMedian(std::move(list));
  return medians;
}

}  // namespace highwall::bench
