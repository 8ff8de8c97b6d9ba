#include "sliding_window_file.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <ostream>
#include <string_view>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall::internal {
namespace {

constexpr const char* kMagic = "highwall_sliding_window";
constexpr int kVersion = 1;
// Larger counts are treated as a damaged file rather than allocated.
constexpr int kMaxCount = 1'000'000;

void WriteDouble(std::ostream& out, double value) {
  out << ' ' << NumberText(value);
}

// Reads the words of a file line by line; errors name the line.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path), stream_(path) {
    if (!stream_) throw IoError(path, "cannot be read");
  }

  void NextLine() {
    ++line_;
    at_ = 0;
    if (!std::getline(stream_, text_)) Fail("ends early");
  }
  // Advances to the next line, which must begin with `keyword`.
  void Line(std::string_view keyword) {
    NextLine();
    if (Word() != keyword) Fail("expected '" + std::string(keyword) + "'");
  }
  std::string Word() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ' ') ++at_;
    return text_.substr(begin, at_ - begin);
  }
  template <class Number>
  Number Read(const char* what) {
    const std::string word = Word();
    Number value{};
    if (!ParseNumber(word, &value)) {
      Fail("expected " + std::string(what) + ", found '" + word + "'");
    }
    return value;
  }
  double Double() {
    const double value = Read<double>("a number");
    if (!std::isfinite(value)) Fail("a number is not finite");
    return value;
  }
  int Count(const char* what) {
    const int count = Read<int>(what);
    if (count < 0 || count > kMaxCount) Fail(std::string(what) + " is out of range");
    return count;
  }
  std::vector<double> Doubles(int count) {
    std::vector<double> values;
    for (int i = 0; i < count; ++i) values.push_back(Double());
    return values;
  }
  void EndOfLine() {
    if (!Word().empty()) Fail("holds more than expected");
  }
  [[noreturn]] void Fail(const std::string& what) const { throw IoError(path_, line_, what); }

 private:
  std::filesystem::path path_;
  std::ifstream stream_;
  std::string text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 0;
};

}  // namespace

void WriteSlidingWindow(const std::filesystem::path& path, const SlidingWindowFile& file) {
  AtomicFile output(path);
  std::ostream& out = output.stream();
  out << kMagic << ' ' << kVersion << '\n';
  out << "variables " << file.variables.size() << '\n';
  for (const SavedVariable& variable : file.variables) {
    out << (variable.calibration ? "calibration " : "state ") << variable.stamp << ' '
        << (variable.fixed ? 1 : 0) << ' ' << variable.type << ' ' << variable.values.size();
    for (const double value : variable.values) WriteDouble(out, value);
    out << '\n';
  }
  out << "prior " << file.b.size() << ' ' << file.A.cols() << ' ' << file.blocks.size() << '\n';
  for (const SavedBlock& block : file.blocks) {
    out << "block " << block.variable << ' ' << block.point.size();
    for (const double value : block.point) WriteDouble(out, value);
    out << '\n';
  }
  for (Eigen::Index i = 0; i < file.b.size(); ++i) {
    out << "row";
    for (Eigen::Index j = 0; j < file.A.cols(); ++j) WriteDouble(out, file.A(i, j));
    WriteDouble(out, file.b[i]);
    out << '\n';
  }
  out << "end\n";
  output.Commit();
}

SlidingWindowFile ReadSlidingWindow(const std::filesystem::path& path) {
  Reader reader(path);
  reader.Line(kMagic);
  if (const int version = reader.Count("a version"); version != kVersion) {
    reader.Fail("version " + std::to_string(version) + " is not known; this is version " +
                std::to_string(kVersion));
  }
  SlidingWindowFile file;
  reader.Line("variables");
  const int variables = reader.Count("the number of variables");
  for (int i = 0; i < variables; ++i) {
    SavedVariable variable;
    reader.NextLine();
    const std::string kind = reader.Word();
    if (kind != "state" && kind != "calibration") reader.Fail("expected 'state' or 'calibration'");
    variable.calibration = kind == "calibration";
    variable.stamp = reader.Read<Stamp>("a stamp");
    variable.fixed = reader.Count("0 or 1") != 0;
    variable.type = reader.Word();
    variable.values = reader.Doubles(reader.Count("a size"));
    reader.EndOfLine();
    file.variables.push_back(std::move(variable));
  }
  reader.Line("prior");
  const int rows = reader.Count("the number of rows");
  const int columns = reader.Count("the number of columns");
  const int blocks = reader.Count("the number of blocks");
  for (int i = 0; i < blocks; ++i) {
    reader.Line("block");
    SavedBlock block;
    block.variable = reader.Count("a variable");
    if (block.variable >= variables) reader.Fail("there is no such variable");
    block.point = reader.Doubles(reader.Count("a size"));
    reader.EndOfLine();
    file.blocks.push_back(std::move(block));
  }
  // Row by row, so that a wrong count fails before it is allocated.
  std::vector<std::vector<double>> matrix;
  for (int i = 0; i < rows; ++i) {
    reader.Line("row");
    matrix.push_back(reader.Doubles(columns + 1));
    reader.EndOfLine();
  }
  reader.Line("end");
  file.A.resize(rows, columns);
  file.b.resize(rows);
  for (int i = 0; i < rows; ++i) {
    const std::vector<double>& row = matrix[static_cast<std::size_t>(i)];
    file.A.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), columns);
    file.b[i] = row.back();
  }
  return file;
}

}  // namespace highwall::internal
