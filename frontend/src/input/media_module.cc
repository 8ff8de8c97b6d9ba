#include "input/media_module.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <highwall/core/error.h>

namespace highwall {
namespace {

namespace fs = std::filesystem;

// The folder of the program or the shared library that contains this function.
fs::path FolderOfHighwall() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&FolderOfHighwall), &info) == 0) return {};
  const fs::path file = info.dli_fname;  // of a program, its first argument
  std::error_code error;
  return fs::canonical(file.is_absolute() ? file : "/proc/self/exe", error).parent_path();
}

std::vector<fs::path> PlacesOfModule() {
  const fs::path below = fs::path(HIGHWALL_LIBDIR) / "highwall" / HIGHWALL_MEDIA_FILE;
  std::vector<fs::path> places;
  for (fs::path folder = FolderOfHighwall(); folder.has_relative_path();
       folder = folder.parent_path()) {
    places.push_back(folder / below);
  }
  places.push_back(HIGHWALL_PREFIX / below);
  return places;
}

const OpenCvMedia* LoadMedia(const fs::path& file) {
  for (const fs::path& place : PlacesOfModule()) {
    std::error_code error;
    if (!fs::exists(place, error)) continue;
    // Never unloaded: libraries of video formats do not support it.
    void* const module = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (module == nullptr) throw IoError(file, std::string("cannot be decoded: ") + dlerror());
    if (const void* const media = dlsym(module, kMediaSymbol)) {
      return static_cast<const OpenCvMedia*>(media);
    }
  }
  throw IoError(file,
                "is neither PNG nor JPEG, and the module for other formats and videos is missing: "
                "keep " HIGHWALL_LIBDIR "/highwall/" HIGHWALL_MEDIA_FILE
                " beside the folder of the program");
}

}  // namespace

const OpenCvMedia& MediaFor(const fs::path& file) {
  static const OpenCvMedia* const media = LoadMedia(file);
  return *media;
}

}  // namespace highwall
