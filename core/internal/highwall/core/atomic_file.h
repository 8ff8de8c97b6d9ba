#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>

#include <highwall/core/file_lock.h>

namespace [[gnu::visibility("default")]] highwall {

// A file that appears whole or not at all: the bytes go to a temporary name beside `path`, and
// Commit() puts it in place of whatever was there. Without Commit() the temporary is removed and
// the old file stays as it was.
class AtomicFile {
 public:
  // A link stays, what it leads to is replaced. Throws IoError if the temporary cannot be opened
  // (the folder must exist) or `path` is a device or a pipe.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Binary, and numbers look the same under every locale; write errors are found by Commit().
  std::ostream& stream() { return stream_; }
  // For writers that open a file by its name themselves (then do not use stream()).
  const std::filesystem::path& temporary() const { return temporary_; }

  // Throws IoError if anything could not be written (disk full), flushed or renamed; the old file
  // is then untouched.
  void Commit();

 private:
  // Remembers why the first write failed: the stream goes on without a word until it is closed.
  class Buffer : public std::filebuf {
   public:
    // False where anything that was left could not be written.
    bool Close();
    int error() const { return error_; }  // errno; 0: none

   protected:
    int overflow(int c) override;
    std::streamsize xsputn(const char* bytes, std::streamsize count) override;
    int sync() override;

   private:
    void Remember(int error) {
      if (error_ == 0) error_ = error;
    }

    int error_ = 0;
  };

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::optional<FileLock> lock_;  // of the temporary: it is in use
  Buffer buffer_;
  std::ostream stream_{&buffer_};
  bool committed_ = false;
};

// A hidden name beside `path` that nothing else has, on whatever machine of a shared file system,
// and that RemoveTemporariesOfDeadProcesses() knows. The extension stays last.
std::filesystem::path TemporaryBeside(const std::filesystem::path& path);

// Removes from a folder what AtomicFile left there in processes that were killed. What may still be
// written stays, by whatever process, container or machine, and so does what cannot be removed.
void RemoveTemporariesOfDeadProcesses(const std::filesystem::path& folder);

}  // namespace highwall
