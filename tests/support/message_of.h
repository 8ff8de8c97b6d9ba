#pragma once

#include <string>

namespace highwall::testing {

// What the `Error` says that `action` throws; empty where it throws none.
template <typename Error, typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace highwall::testing
