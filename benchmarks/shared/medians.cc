#include "medians.h"

#include <algorithm>
#include <utility>

namespace highwall::bench {

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Scores Medians(const std::vector<Scores>& runs) {
  std::map<std::string, std::vector<double>> values;
  for (const Scores& run : runs) {
    for (const auto& [name, value] : run) values[name].push_back(value);
  }
  Scores medians;
  for (auto& [name, list] : values) medians[name] = Median(std::move(list));
  return medians;
}

}  // namespace highwall::bench
