#include "input/opencv_storage.h"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

// The elements of XML as FileStorage writes it: text or elements, without entities and CDATA.
class StorageXml {
 public:
  StorageXml(const std::filesystem::path& path, std::string_view text) : path_(path), text_(text) {}

  // Returns the members of <opencv_storage>.
  ForeignMap::Members Read() {
    if (Open() != kRoot) Fail("has no <opencv_storage>");
    ForeignMap::Members members;
    while (!Close(kRoot)) {
      const std::string name = Open();
      const std::int64_t line = Line();
      members.insert_or_assign(name, ForeignMap::Member{line, Content(name, 1)});
    }
    return members;
  }

 private:
  static constexpr std::string_view kRoot = "opencv_storage";
  static constexpr int kDeepest = 8;  // a matrix of a calibration is two elements deep

  [[noreturn]] void Fail(const std::string& what) {
    throw IoError(path_, Line(), "is not XML of OpenCV: " + what);
  }
  // Counts on from the last call.
  std::int64_t Line() {
    line_ += std::ranges::count(text_.substr(counted_, at_ - counted_), '\n');
    counted_ = at_;
    return line_;
  }

  // Moves behind the next occurrence of a text.
  void SkipPast(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) Fail("it ends within a tag");
    at_ = found + end.size();
  }

  // Moves to the next tag, over blanks, declarations and comments.
  void SkipToTag() {
    for (;;) {
      at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size());
      const std::string_view rest = text_.substr(at_);
      if (rest.starts_with("<?")) {
        SkipPast("?>");
      } else if (rest.starts_with("<!--")) {
        SkipPast("-->");
      } else {
        return;
      }
    }
  }

  // Reads <name ...>.
  std::string Open() {
    SkipToTag();
    if (!text_.substr(at_).starts_with('<')) Fail("expected a tag");
    const std::size_t begin = at_ + 1;
    SkipPast(">");
    const std::string_view tag = text_.substr(begin, at_ - begin - 1);
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/"));
    if (name.empty()) Fail("expected the name of a tag");
    is_empty_ = tag.ends_with('/');
    return std::string(name);
  }

  // Reads </name> if it is next.
  bool Close(std::string_view name) {
    SkipToTag();
    const std::string tag = "</" + std::string(name) + ">";
    if (!text_.substr(at_).starts_with(tag)) return false;
    at_ += tag.size();
    return true;
  }

  // Reads what is between <name> and </name>: several words are a list.
  YAML::Node Content(const std::string& name, int depth) {
    if (depth > kDeepest) Fail("its tags are nested too deeply");
    YAML::Node node;
    if (is_empty_) return node;
    SkipToTag();
    if (text_.substr(at_).starts_with('<')) {
      while (!Close(name)) {
        const std::string key = Open();
        YAML::Node value = Content(key, depth + 1);
        node.force_insert(key, value);
      }
      return node;
    }
    const std::size_t end = std::min(text_.find('<', at_), text_.size());
    const auto words = SplitWords(text_.substr(at_, end - at_), kBlanks);
    at_ = end;
    if (!Close(name)) Fail("expected </" + name + ">");
    if (words.size() == 1) return YAML::Node(std::string(words.front()));
    for (const std::string_view word : words) node.push_back(std::string(word));
    return node;
  }

  const std::filesystem::path& path_;
  const std::string_view text_;
  std::size_t at_ = 0, counted_ = 0;
  std::int64_t line_ = 1;  // of counted_
  bool is_empty_ = false;  // the tag that Open() read, as <name/>
};

}  // namespace

bool IsOpencvXml(const std::string& text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first != std::string::npos && text[first] == '<' &&
         text.find("<opencv_storage") != std::string::npos;
}

ForeignMap ParseOpencvStorage(const std::filesystem::path& path, const std::string& text) {
  if (IsOpencvXml(text)) return {path, StorageXml(path, text).Read()};
  std::string yaml = text;
  if (yaml.starts_with("%YAML:")) yaml.front() = '#';  // lines keep their numbers
  return ForeignMap::Parse(path, yaml, "YAML");
}

}  // namespace highwall
