#include <highwall/core/atomic_file.h>

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <highwall/core/error.h>

namespace highwall {
namespace {

// No other live object has this address in this process: writers of one path do not meet.
std::string UniqueSuffix(const AtomicFile* file) {
  std::ostringstream text;
  text << ::getpid() << "-" << static_cast<const void*>(file);
  return text.str();
}

// The process in a suffix; 0 for another text.
pid_t ProcessOf(std::string_view suffix) {
  const std::size_t dash = suffix.find("-0x");
  if (dash == std::string_view::npos) return 0;
  const auto all = [](std::string_view digits, auto& value, int base) {
    const char* const end = digits.data() + digits.size();
    const auto [last, error] = std::from_chars(digits.data(), end, value, base);
    return error == std::errc() && last == end;
  };
  pid_t process = 0;
  std::uintptr_t address = 0;
  const bool whole =
      all(suffix.substr(0, dash), process, 10) && all(suffix.substr(dash + 3), address, 16);
  return whole && process > 0 ? process : 0;
}

// The suffix is the extension, or stands before it.
bool IsLeftBehind(const std::filesystem::path& file) {
  if (!file.filename().string().starts_with('.')) return false;
  for (const std::filesystem::path& part : {file.filename(), file.stem()}) {
    const std::string suffix = part.extension().string();
    const pid_t process = suffix.empty() ? 0 : ProcessOf(std::string_view(suffix).substr(1));
    if (process != 0) return ::kill(process, 0) != 0 && errno == ESRCH;
  }
  return false;
}

// What a link leads to: it stays a link. A device or a pipe must not be replaced by a file.
std::filesystem::path Target(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return path;
  const bool replaceable =
      std::filesystem::is_regular_file(path, error) || std::filesystem::is_directory(path, error);
  if (!replaceable) throw IoError(path, "is not a regular file");
  if (!std::filesystem::is_symlink(path, error)) return path;
  return std::filesystem::canonical(path);
}

}  // namespace

int AtomicFile::Buffer::overflow(int c) {
  errno = 0;
  const int result = std::filebuf::overflow(c);
  if (result == traits_type::eof()) Remember(errno);
  return result;
}

std::streamsize AtomicFile::Buffer::xsputn(const char* bytes, std::streamsize count) {
  errno = 0;
  const std::streamsize written = std::filebuf::xsputn(bytes, count);
  if (written != count) Remember(errno);
  return written;
}

int AtomicFile::Buffer::sync() {
  errno = 0;
  const int result = std::filebuf::sync();
  if (result != 0) Remember(errno);
  return result;
}

bool AtomicFile::Buffer::Close() {
  errno = 0;
  const bool closed = close() != nullptr;
  if (!closed) Remember(errno);
  return closed;
}

AtomicFile::AtomicFile(const std::filesystem::path& path)
    : path_(Target(path)),
      // The extension stays last: writers that choose a format by it must see it.
      temporary_(path_.parent_path() / ("." + path_.stem().string() + "." + UniqueSuffix(this) +
                                        path_.extension().string())) {
  if (buffer_.open(temporary_, std::ios::out | std::ios::binary | std::ios::trunc) == nullptr) {
    throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
  }
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  buffer_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::Commit() {
  if (!buffer_.Close() || stream_.fail()) {
    throw IoError(path_, std::string("could not be written whole: ") +
                             (buffer_.error() != 0 ? std::strerror(buffer_.error())
                                                   : "the writer has failed"));
  }
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) throw IoError(path_, "could not be put in place: " + error.message());
  committed_ = true;
}

void RemoveTemporariesOfDeadProcesses(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> dead;
  for (std::filesystem::directory_iterator i(folder, error), end; !error && i != end;
       i.increment(error)) {
    if (IsLeftBehind(i->path())) dead.push_back(i->path());
  }
  for (const std::filesystem::path& file : dead) std::filesystem::remove(file, error);
}

}  // namespace highwall
