#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <bzlib.h>
#include <libdeflate.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include "support/bag_messages.h"

// Writers of the files in which ROS 1 and ROS 2 record messages, as far as tests need them.
namespace highwall::testing {

template <class T>
std::string LittleEndian(T value) {
  std::string text(sizeof(T), '\0');
  std::memcpy(text.data(), &value, sizeof(T));
  return text;
}

inline std::string Counted(const std::string& text) {
  return LittleEndian(static_cast<std::uint32_t>(text.size())) + text;
}

// compression: "none", "bz2", "lz4" or "zstd".
inline std::string Compressed(const std::string& text, const std::string& compression) {
  std::string out;
  if (compression == "bz2") {
    out.resize(text.size() + text.size() / 50 + 700);
    auto size = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(text.data()),
                             static_cast<unsigned>(text.size()), 1, 0, 0);
    out.resize(size);
  } else if (compression == "lz4") {
    out.resize(LZ4F_compressFrameBound(text.size(), nullptr));
    out.resize(LZ4F_compressFrame(out.data(), out.size(), text.data(), text.size(), nullptr));
  } else if (compression == "zstd") {
    out.resize(ZSTD_compressBound(text.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 1));
  } else {
    return text;
  }
  return out;
}

// The largest content of a chunk, so that there are several.
inline constexpr std::size_t kChunkSize = 300'000;  // [byte]

using RosbagHeader = std::vector<std::pair<std::string, std::string>>;

inline std::string RosbagRecord(const RosbagHeader& header, const std::string& data) {
  std::string fields;
  for (const auto& [name, value] : header) fields += Counted(name + "=" + value);
  return Counted(fields) + Counted(data);
}

// A bag of ROS 1, without the index that its reader does not need except in name.
inline std::string RosbagOf(const std::vector<WrittenMessage>& messages,
                            const std::string& compression = "none", bool is_indexed = true) {
  const auto op = [](char value) { return std::pair("op", std::string(1, value)); };
  std::map<std::string, std::uint32_t> connections;
  std::string chunks, content;
  const auto end_chunk = [&] {
    if (content.empty()) return;
    chunks += RosbagRecord({op('\5'),
                            {"compression", compression},
                            {"size", LittleEndian(static_cast<std::uint32_t>(content.size()))}},
                           Compressed(content, compression));
    chunks += RosbagRecord({op('\4'),
                            {"ver", LittleEndian(1U)},
                            {"conn", LittleEndian(0U)},
                            {"count", LittleEndian(0U)}},
                           "");
    content.clear();
  };
  std::string connection_records;
  for (const WrittenMessage& message : messages) {
    const auto [found, is_new] =
        connections.emplace(message.topic, static_cast<std::uint32_t>(connections.size()));
    if (is_new) {
      std::string data;
      for (const std::string& field :
           {"topic=" + message.topic, "type=" + message.type, std::string("md5sum=*"),
            std::string("message_definition=")}) {
        data += Counted(field);
      }
      const std::string record = RosbagRecord(
          {op('\7'), {"conn", LittleEndian(found->second)}, {"topic", message.topic}}, data);
      content += record;
      connection_records += record;
    }
    const auto seconds = static_cast<std::uint32_t>(message.recorded / 1'000'000'000);
    const auto rest = static_cast<std::uint32_t>(message.recorded % 1'000'000'000);
    content += RosbagRecord({op('\2'),
                             {"conn", LittleEndian(found->second)},
                             {"time", LittleEndian(seconds) + LittleEndian(rest)}},
                            message.bytes);
    if (content.size() > kChunkSize) end_chunk();
  }
  end_chunk();
  const std::string magic = "#ROSBAG V2.0\n";
  const auto bag_header = [&](std::uint64_t index) {
    return RosbagRecord(
        {op('\3'),
         {"index_pos", LittleEndian(index)},
         {"conn_count", LittleEndian(static_cast<std::uint32_t>(connections.size()))},
         {"chunk_count", LittleEndian(1U)}},
        std::string(100, ' '));
  };
  const std::uint64_t index = magic.size() + bag_header(0).size() + chunks.size();
  return magic + bag_header(is_indexed ? index : 0) + chunks +
         (is_indexed ? connection_records : "");
}

// The name of a type in ROS 2.
inline std::string Ros2Type(std::string type) {
  return type.insert(type.find('/'), "/msg");
}

// A file of MCAP. compression: of its chunks; "unchunked": there are none.
inline std::string McapOf(const std::vector<WrittenMessage>& messages,
                          const std::string& compression = "none", bool is_ros1 = false) {
  const auto record = [](char op, const std::string& data) {
    return std::string(1, op) + LittleEndian(static_cast<std::uint64_t>(data.size())) + data;
  };
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string file = magic + record('\1', Counted("ros2") + Counted("test")), content;
  const auto end_chunk = [&] {
    if (content.empty()) return;
    const std::string stored = Compressed(content, compression);
    file += record('\6', std::string(16, '\0') +
                             LittleEndian(static_cast<std::uint64_t>(content.size())) +
                             LittleEndian(libdeflate_crc32(0, content.data(), content.size())) +
                             Counted(compression == "none" ? "" : compression) +
                             LittleEndian(static_cast<std::uint64_t>(stored.size())) + stored);
    content.clear();
  };
  std::string& target = compression == "unchunked" ? file : content;
  std::map<std::string, std::uint16_t> channels;
  for (const WrittenMessage& message : messages) {
    const auto [found, is_new] =
        channels.emplace(message.topic, static_cast<std::uint16_t>(channels.size() + 1));
    const std::string id = LittleEndian(found->second);
    if (is_new) {
      target += record('\3', id + Counted(is_ros1 ? message.type : Ros2Type(message.type)) +
                                 Counted("ros2msg") + Counted(""));
      target += record('\4', id + id + Counted(message.topic) + Counted(is_ros1 ? "ros1" : "cdr") +
                                 LittleEndian(0U));
    }
    const auto time = LittleEndian(static_cast<std::uint64_t>(message.recorded));
    target += record('\5', id + LittleEndian(0U) + time + time + message.bytes);
    if (content.size() > kChunkSize) end_chunk();
  }
  end_chunk();
  return file + record('\x0F', LittleEndian(0U)) + record('\2', std::string(20, '\0')) + magic;
}

// A database of ROS 2. compressed: each message by itself. page: [byte]
inline void WriteSqliteBag(const std::filesystem::path& path,
                           const std::vector<WrittenMessage>& messages, bool compressed = false,
                           int page = 4096) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  const std::string pages = "PRAGMA page_size = " + std::to_string(page);
  sqlite3_exec(database, pages.c_str(), nullptr, nullptr, nullptr);
  sqlite3_exec(database,
               "PRAGMA journal_mode = OFF; BEGIN;"
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
               " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
               " timestamp INTEGER NOT NULL, data BLOB NOT NULL);",
               nullptr, nullptr, nullptr);
  std::map<std::string, int> topics;
  for (const WrittenMessage& message : messages) {
    const auto [found, is_new] = topics.emplace(message.topic, static_cast<int>(topics.size()) + 1);
    if (is_new) {
      const std::string insert = "INSERT INTO topics VALUES(" + std::to_string(found->second) +
                                 ", '" + message.topic + "', '" + Ros2Type(message.type) +
                                 "', 'cdr', '')";
      sqlite3_exec(database, insert.c_str(), nullptr, nullptr, nullptr);
    }
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                       -1, &statement, nullptr);
    const std::string data = compressed ? Compressed(message.bytes, "zstd") : message.bytes;
    sqlite3_bind_int(statement, 1, found->second);
    sqlite3_bind_int64(statement, 2, message.recorded);
    sqlite3_bind_blob(statement, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    sqlite3_step(statement);
    sqlite3_finalize(statement);
  }
  sqlite3_exec(database, "COMMIT;", nullptr, nullptr, nullptr);
  sqlite3_close(database);
}

}  // namespace highwall::testing
