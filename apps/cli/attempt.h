#pragma once

#include <exception>
#include <string>
#include <vector>

namespace highwall::apps {

// Runs `work` and records an exception in `failures`, prefixed with `what`: it is better to lose a
// part of a run than all of it. Returns false on failure.
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
