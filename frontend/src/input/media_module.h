#pragma once

#include <filesystem>

#include "media/opencv_media.h"

namespace highwall {

// Returns OpenCV's decoders of rare image formats and of videos. The module that holds them, and with
// it some 200 libraries that take 60 MiB and a quarter of a second, is loaded at the first call. It
// is searched in lib/highwall beside the folders above the program or library that contains Highwall,
// and where it was installed. May be called from several threads. Throws IoError, which names the
// file that is to be read, if it cannot be loaded.
const OpenCvMedia& MediaFor(const std::filesystem::path& file);

}  // namespace highwall
