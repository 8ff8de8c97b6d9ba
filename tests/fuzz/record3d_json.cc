#include "input/record3d_metadata.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "metadata.json",
    .seeds =
        [] {
          return std::vector<std::string>{
              "{\"w\":1440,\"h\":1920,\"fps\":60,\"K\":[1404.3,0,0,0,1404.3,0,724.6,963.7,1],"
              "\"frameTimestamps\":[0,0.0166],\"poses\":[[0.24,0.75,0.35,-0.49,0.27,-0.04,0.95],"
              "[0,0,0,0,0,0,0]],\"perFrameIntrinsicCoeffs\":[[1400,1400,724,963],[1,1,0,0]]}",
              "{\"K\":[1,0,0,0,1,0,0,0,1],\"w\":1,\"h\":1,\"poses\":[]}"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadRecord3dMetadata(path); },
};

}  // namespace highwall::fuzz
