#include "misuses.h"

#include <algorithm>
#include <iterator>

namespace highwall::bench {

std::string NameOf(const Misuse& misuse) {
  return misuse.strength.empty() ? misuse.fault : misuse.fault + " " + misuse.strength;
}

std::vector<Misuse> AllMisuses() {
  std::vector<Misuse> all;
  for (const auto& misuses : {DepthMisuses(), LensMisuses(), ImuMisuses(), StampMisuses()}) {
    std::ranges::copy(misuses, std::back_inserter(all));
  }
  return all;
}

std::vector<std::string> AllFaults() {
  std::vector<std::string> faults;
  for (const Misuse& misuse : AllMisuses()) {
    if (std::ranges::find(faults, misuse.fault) == faults.end()) faults.push_back(misuse.fault);
  }
  return faults;
}

}  // namespace highwall::bench
