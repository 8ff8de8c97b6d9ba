#include "input/matrix_text.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

namespace highwall {

Eigen::MatrixXd ReadMatrixText(const std::filesystem::path& path, int rows, int columns) {
  TextReader file(ReadTextFile(path));
  const std::string form =
      std::to_string(rows) + " lines of " + std::to_string(columns) + " numbers";
  Eigen::MatrixXd matrix(rows, columns);
  int row = 0;
  std::string line;
  for (std::int64_t number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string_view> words = SplitWords(line, " \t\r,;");
    if (words.empty() || words.front().starts_with('#')) continue;
    if (row == rows) throw IoError(path, number, "has more than " + form);
    if (words.size() != static_cast<std::size_t>(columns)) {
      throw IoError(path, number, "has " + std::to_string(words.size()) + " of " + form);
    }
    for (int column = 0; column < columns; ++column) {
      const std::string_view word = words[static_cast<std::size_t>(column)];
      const std::optional<double> value = ReadNumber<double>(word);
      if (!value) throw IoError(path, number, "'" + std::string(word) + "' is not a number");
      matrix(row, column) = *value;
    }
    ++row;
  }
  if (row < rows) throw IoError(path, "has " + std::to_string(row) + " of " + form);
  return matrix;
}

PinholeCamera CameraOfMatrix(const std::filesystem::path& path, std::span<const double> matrix) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (matrix.size() != 9 || !std::ranges::all_of(matrix, finite)) {
    throw IoError(path, "the camera matrix must be nine finite numbers");
  }
  const bool by_rows = matrix[6] == 0.0 && matrix[7] == 0.0;
  const bool by_columns = matrix[2] == 0.0 && matrix[5] == 0.0;
  if (by_rows == by_columns || matrix[1] != 0.0 || matrix[3] != 0.0 || matrix[8] != 1.0 ||
      !(matrix[0] > 0.0) || !(matrix[4] > 0.0)) {
    throw IoError(path, "the camera matrix must be fx 0 cx, 0 fy cy, 0 0 1");
  }
  return {.width = 0,
          .height = 0,
          .fx = matrix[0],
          .fy = matrix[4],
          .cx = matrix[by_rows ? 2 : 6],
          .cy = matrix[by_rows ? 5 : 7]};
}

}  // namespace highwall
