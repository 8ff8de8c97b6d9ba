#include "input/trajectory_log.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

namespace highwall {
namespace {

// Reads the lines that are not empty, and counts all.
class LogLines {
 public:
  explicit LogLines(const std::filesystem::path& path) : path_(path), text_(ReadTextFile(path)) {}

  // Returns false at the end.
  bool Next() {
    while (std::getline(text_, line_)) {
      ++number_;
      words_ = SplitWords(line_, " \t\r");
      if (!words_.empty()) return true;
    }
    return false;
  }
  const std::vector<std::string_view>& words() const { return words_; }
  [[noreturn]] void Refuse(const std::string& what) const { throw IoError(path_, number_, what); }

 private:
  std::filesystem::path path_;
  TextReader text_;
  std::string line_;
  std::vector<std::string_view> words_;
  std::int64_t number_ = 0;
};

Pose ReadLoggedPose(LogLines* lines) {
  Eigen::Matrix4d T;
  for (int row = 0; row < 4; ++row) {
    if (!lines->Next()) lines->Refuse("ends inside of a pose");
    if (lines->words().size() != 4) lines->Refuse("must hold four numbers of a pose");
    for (int column = 0; column < 4; ++column) {
      const std::string_view word = lines->words()[static_cast<std::size_t>(column)];
      const std::optional<double> value = ReadNumber<double>(word);
      if (!value) lines->Refuse("'" + std::string(word) + "' is not a number");
      T(row, column) = *value;
    }
  }
  try {
    return Pose::FromMatrix(T);
  } catch (const InvalidArgument&) {  // the file's fault, which IoError reports
    lines->Refuse("ends a matrix that is no rotation and translation");
  }
}

}  // namespace

std::vector<LoggedPose> ReadTrajectoryLog(const std::filesystem::path& path) {
  LogLines lines(path);
  std::vector<LoggedPose> poses;
  while (lines.Next()) {
    const std::optional<std::uint32_t> frame = ReadNumber<std::uint32_t>(lines.words().front());
    if (lines.words().size() != 3 || !frame) {
      lines.Refuse("must hold three whole numbers, the first of which is that of the frame");
    }
    const Pose pose = ReadLoggedPose(&lines);
    poses.push_back({*frame, pose});
  }
  if (poses.empty()) throw IoError(path, "holds no pose");
  return poses;
}

}  // namespace highwall
