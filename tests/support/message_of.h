#pragma once

#include <string>

#include <gtest/gtest.h>
#include <highwall/core/error.h>

namespace highwall::testing {

// Returns the message of the `Error` thrown by `action`, or an empty text if it throws none.
template <typename Error, typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Expects that `action` throws an `Error` whose message contains `text`, such as the name of a
// field.
template <typename Error = InvalidArgument, typename Action>
void ExpectError(const std::string& text, const Action& action) {
  const std::string message = MessageOf<Error>(action);
  EXPECT_FALSE(message.empty()) << "nothing is thrown: " << text;
  EXPECT_NE(message.find(text), std::string::npos) << message;
}

}  // namespace highwall::testing
