#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>

#include <highwall/core/file_lock.h>

namespace [[gnu::visibility("default")]] highwall {

// A file that is written atomically: the bytes go to a temporary file next to `path`, and Commit()
// renames it to `path`, replacing an existing file. Without Commit() the temporary is removed and
// the old file stays unchanged.
class AtomicFile {
 public:
  // A symbolic link is kept and its target replaced. Throws IoError if the temporary cannot be
  // opened (the folder must exist) or `path` is a device or a pipe.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Binary, with the classic locale; write errors are reported by Commit().
  std::ostream& stream() { return stream_; }
  // For writers that open a file by its name themselves (then do not use stream()).
  const std::filesystem::path& temporary() const { return temporary_; }

  // Throws IoError if anything could not be written (disk full), flushed or renamed; the old file
  // is then untouched.
  void Commit();

 private:
  // Stores the error of the first failed write, since the stream reports none until it is closed.
  class Buffer : public std::filebuf {
   public:
    // Returns false if buffered bytes could not be written.
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
  std::optional<FileLock> lock_;  // marks the temporary as in use
  Buffer buffer_;
  std::ostream stream_{&buffer_};
  bool committed_ = false;
};

// Returns a hidden file name next to `path` that is unique, even across the machines of a shared
// file system, and that RemoveTemporariesOfDeadProcesses() recognises. The extension stays last.
std::filesystem::path TemporaryBeside(const std::filesystem::path& path);

// Removes from a folder the temporaries of AtomicFile that killed processes left there. Files that
// a process, in whatever container or machine, may still be writing are kept, and so are files that
// cannot be removed.
void RemoveTemporariesOfDeadProcesses(const std::filesystem::path& folder);

}  // namespace highwall
