#pragma once

#include <stdexcept>

namespace highwall::apps {

// Thrown if the camera that the user asks for is not there; the message says what to do.
class NoCamera : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace highwall::apps
