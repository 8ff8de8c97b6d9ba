#include "input/scanner_app_frame.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "frame_00000.json",
    .seeds =
        [] {
          return std::vector<std::string>{
              "{\n  \"time\" : 104137.33988787502,\n  \"intrinsics\" : [1590.2, 0, 947.3, 0, "
              "1590.2, "
              "727.5, 0, 0, 1],\n  \"cameraPoseARFrame\" : [1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1, 6, 0, "
              "0, "
              "0, 0.99999994]\n}\n",
              "{\"time\":1e9,\"intrinsics\":[1,0,0,0,1,0,0,0,1]}"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadScannerAppFrame(path); },
};

}  // namespace highwall::fuzz
