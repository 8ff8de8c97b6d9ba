#include "input/sqlite_bag.h"

#include <algorithm>
#include <string>
#include <utility>

#include <sqlite3.h>

#include <highwall/core/error.h>

#include "input/decompression.h"
#include "input/random_access_file.h"

namespace highwall {
namespace {

[[noreturn]] void RefuseDatabase(const std::filesystem::path& path, sqlite3* database) {
  throw IoError(path,
                std::string("is no bag of ROS 2, or is damaged: ") + sqlite3_errmsg(database));
}

// A prepared query.
class Query {
 public:
  Query(const std::filesystem::path& path, sqlite3* database, const char* text)
      : path_(path), database_(database) {
    sqlite3_stmt* statement = nullptr;
    const int result = sqlite3_prepare_v2(database, text, -1, &statement, nullptr);
    statement_.reset(statement);
    if (result != SQLITE_OK) RefuseDatabase(path, database);
  }

  // Steps to the next row; returns false behind the last.
  bool Next() {
    const int result = sqlite3_step(statement_.get());
    if (result != SQLITE_ROW && result != SQLITE_DONE) RefuseDatabase(path_, database_);
    return result == SQLITE_ROW;
  }
  std::int64_t Integer(int column) { return sqlite3_column_int64(statement_.get(), column); }
  std::string Text(int column) {
    const auto* const text = sqlite3_column_text(statement_.get(), column);
    if (text == nullptr) return "";
    return {reinterpret_cast<const char*>(text),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
  }

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };

  const std::filesystem::path& path_;
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};

}  // namespace

void SqliteBag::Close::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

SqliteBag::SqliteBag(const std::filesystem::path& path) : BagFile(path) {
  if (RandomAccessFile(path).size() == 0) throw IoError(path, "is empty");
  sqlite3* database = nullptr;
  const int opened =
      sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  if (opened != SQLITE_OK) RefuseDatabase(path, database);
  std::vector<std::pair<std::int64_t, std::uint32_t>> topics;
  ReadTopics(&topics);
  ReadMessages(topics);
  Sort();
}

void SqliteBag::ReadTopics(std::vector<std::pair<std::int64_t, std::uint32_t>>* topics) {
  Query query(path(), database_.get(),
              "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (query.Next()) {
    const MessageEncoding encoding =
        query.Text(3) == "cdr" ? MessageEncoding::kCdr : MessageEncoding::kOther;
    topics->emplace_back(query.Integer(0), AddTopic(query.Text(1), query.Text(2), encoding));
  }
}

void SqliteBag::ReadMessages(const std::vector<std::pair<std::int64_t, std::uint32_t>>& topics) {
  Query query(path(), database_.get(),
              "SELECT rowid, topic_id, timestamp, length(data) FROM messages "
              "WHERE typeof(data) = 'blob'");
  while (query.Next()) {
    const auto topic =
        std::ranges::find(topics, query.Integer(1), &std::pair<std::int64_t, std::uint32_t>::first);
    if (topic == topics.end()) throw IoError(path(), "is damaged: a message has no topic");
    BagMessage message{.recorded = RecordedStamp(static_cast<std::uint64_t>(query.Integer(2))),
                       .topic = topic->second,
                       .part = 0,
                       .offset = static_cast<std::uint64_t>(query.Integer(0)),
                       .size = static_cast<std::uint64_t>(query.Integer(3))};
    std::vector<std::uint8_t> head = ReadRow(query.Integer(0), BagMessage::kHead);
    if (IsZstd(head)) head = Read(message);
    std::copy_n(head.begin(), std::min(head.size(), BagMessage::kHead), message.head.begin());
    AddMessage(message);
  }
}

std::vector<std::uint8_t> SqliteBag::Read(const BagMessage& message) const {
  return ContentOf(message, ReadRow(static_cast<std::int64_t>(message.offset), kLargestMessage));
}

// A connection serves one thread at a time.
std::vector<std::uint8_t> SqliteBag::ReadRow(std::int64_t row, std::uint64_t most) const {
  const std::scoped_lock lock(mutex_);
  sqlite3_blob* opened = nullptr;
  const int result =
      sqlite3_blob_open(database_.get(), "main", "messages", "data", row, 0, &opened);
  const std::unique_ptr<sqlite3_blob, CloseBlob> blob(opened);
  if (result != SQLITE_OK) RefuseDatabase(path(), database_.get());
  const auto size = static_cast<std::uint64_t>(std::max(0, sqlite3_blob_bytes(blob.get())));
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min(size, most)));
  if (sqlite3_blob_read(blob.get(), bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK) {
    RefuseDatabase(path(), database_.get());
  }
  return bytes;
}

}  // namespace highwall
