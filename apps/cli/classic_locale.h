#pragma once

#include <locale>
#include <string>

namespace highwall::apps {

// Sets the process to the "C" locale during its lifetime: CLI11 parses numbers with strtold and
// prints defaults through streams. Construct it before any threads start, since both locales are
// process-wide.
class ClassicLocale {
 public:
  ClassicLocale();
  ~ClassicLocale();
  ClassicLocale(const ClassicLocale&) = delete;
  ClassicLocale& operator=(const ClassicLocale&) = delete;

 private:
  const std::string c_;  // from setlocale()
  const std::locale cpp_;
};

}  // namespace highwall::apps
