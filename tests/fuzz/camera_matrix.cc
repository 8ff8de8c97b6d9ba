#include "input/matrix_text.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "camera_matrix.csv",
    .seeds =
        [] {
          return std::vector<std::string>{
              "1352.0168, 0.0, 962.04865\n0.0, 1352.0168, 722.88153\n0.0, 0.0, 1.0",
              "# K\n585 0 320\n\n0 585 240\r\n0 0 1\n", "585 0 0\n0 585 0\n320 240 1\n"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const Eigen::Matrix3d K = ReadMatrixText(path, 3, 3);
          CameraOfMatrix(path, {K.data(), static_cast<std::size_t>(K.size())});
        },
};

}  // namespace highwall::fuzz
