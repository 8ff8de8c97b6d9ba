#include "cli/classic_locale.h"

#include <clocale>

namespace highwall::apps {

ClassicLocale::ClassicLocale() : c_(std::setlocale(LC_ALL, nullptr)) {
  std::locale::global(std::locale::classic());  // also calls setlocale()
}

ClassicLocale::~ClassicLocale() {
  std::locale::global(cpp_);
  std::setlocale(LC_ALL, c_.c_str());
}

}  // namespace highwall::apps
