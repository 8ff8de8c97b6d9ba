#include <highwall/core/atomic_file.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <locale>
#include <random>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

// The name of a temporary ends in ".hw<system>-<number>", before its extension.
constexpr std::string_view kMark = ".hw";
constexpr std::size_t kSystemDigits = 8, kNumberDigits = 16;
constexpr const char* kUnknownSystem = "00000000";

bool IsHexadecimal(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// Identifies the running system since its last boot: containers share the id, other machines do
// not.
std::string ThisSystem() {
  std::ifstream stream("/proc/sys/kernel/random/boot_id");
  std::string id;
  stream >> id;
  id.resize(kSystemDigits, 'x');
  return IsHexadecimal(id) ? id : kUnknownSystem;
}

std::string RandomNumber() {
  std::random_device random;
  const std::uint64_t number = (std::uint64_t{random()} << 32) | std::uint64_t{random()};
  TextWriter text;
  text << std::hex << std::setfill('0') << std::setw(kNumberDigits) << number;
  return text.str();
}

// Returns the id of the system whose process created a temporary; empty for any other file.
std::string SystemOf(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  if (!name.starts_with('.')) return "";
  for (const std::filesystem::path& part : {file.filename(), file.stem()}) {
    const std::string suffix = part.extension().string();
    if (suffix.size() != kMark.size() + kSystemDigits + 1 + kNumberDigits) continue;
    const std::string system = suffix.substr(kMark.size(), kSystemDigits);
    const bool is_temporary = suffix.starts_with(kMark) && IsHexadecimal(system) &&
                              suffix[kMark.size() + kSystemDigits] == '-' &&
                              IsHexadecimal(suffix.substr(kMark.size() + kSystemDigits + 1));
    if (is_temporary) return system;
  }
  return "";
}

bool IsOld(const std::filesystem::path& file) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(file, error);
  return !error && std::filesystem::file_time_type::clock::now() - written > std::chrono::hours(24);
}

// Removes a temporary unless a process may still be writing it: a writer holds its lock. For a
// temporary of another system a free lock proves nothing, since some file systems keep locks local
// to each machine.
void RemoveIfLeftBehind(const std::filesystem::path& file, const std::string& system) {
  const bool is_here = system == ThisSystem() && system != kUnknownSystem;
  if (!is_here && !IsOld(file)) return;
  const FileLock lock(file, FileLock::Open::kExisting);
  std::error_code ignored;
  if (lock.state() == FileLock::State::kHeld) std::filesystem::remove(file, ignored);
}

// Returns the target of a link, which stays a link. A device or a pipe must not be replaced by a
// file.
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

AtomicFile::AtomicFile(const std::filesystem::path& path) : path_(Target(path)) {
  stream_.imbue(std::locale::classic());
  const auto is_in_use = [this] {  // by a process that is removing it, or that has the same name
    const FileLock::State state = lock_->state();
    return state == FileLock::State::kTaken || state == FileLock::State::kRemoved ||
           lock_->error() == EEXIST;
  };
  do {
    temporary_ = TemporaryBeside(path_);
    lock_.emplace(temporary_, FileLock::Open::kNew);
  } while (is_in_use());
  errno = lock_->error();
  if (errno == 0 &&
      buffer_.open(temporary_, std::ios::out | std::ios::binary | std::ios::trunc) != nullptr) {
    return;
  }
  const std::string reason = std::strerror(errno);
  std::error_code ignored;
  if (lock_->error() == 0) std::filesystem::remove(temporary_, ignored);
  throw IoError(path, "cannot be written: " + reason);
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

std::filesystem::path TemporaryBeside(const std::filesystem::path& path) {
  return path.parent_path() / ("." + path.stem().string() + std::string(kMark) + ThisSystem() +
                               "-" + RandomNumber() + path.extension().string());
}

void RemoveTemporariesOfDeadProcesses(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::pair<std::filesystem::path, std::string>> temporaries;
  for (std::filesystem::directory_iterator i(folder, error), end; !error && i != end;
       i.increment(error)) {
    const std::string system = SystemOf(i->path());
    if (!system.empty()) temporaries.emplace_back(i->path(), system);
  }
  for (const auto& [file, system] : temporaries) RemoveIfLeftBehind(file, system);
}

}  // namespace highwall
