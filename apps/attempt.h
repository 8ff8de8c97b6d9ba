#pragma once

#include <exception>
#include <string>
#include <vector>

namespace highwall::apps {

// Does `work`; what it throws joins `failures` under the name `what`, for to lose a part of a run
// is better than to lose all of it. False where it failed.
template <class Work>
bool Attempt(const char* what, std::vector<std::string>* failures, const Work& work) {
  try {
    work();
    return true;
  } catch (const std::exception& error) {
    failures->push_back(std::string(what) + ": " + error.what());
    return false;
  }
}

}  // namespace highwall::apps
