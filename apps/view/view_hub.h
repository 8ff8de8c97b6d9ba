#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "view/event_channel.h"
#include "view/scene_blocks.h"

namespace highwall::apps {

// Distributes the picture of a run to its clients. Thread-safe; no call waits for a client, except
// the client's own Next(). No other lock is held while the hub holds its own.
class ViewHub {
 public:
  static constexpr std::size_t kMaxClients = 8;
  static constexpr std::size_t kBlockBytesPerSecond = 1 << 20;  // of blocks, to each client

  explicit ViewHub(std::size_t block_bytes_per_second = kBlockBytesPerSecond)
      : block_bytes_per_second_(block_bytes_per_second) {}

  // Posts an event, of which only the latest counts: a new client receives the latest of each name.
  void Post(const std::string& name, std::string data);
  // Sets a block of the scene, or removes all whose keys begin with `prefix`.
  void SetBlock(const std::string& key, std::string data);
  void RemoveBlocks(const std::string& prefix);
  bool HasClients() const { return clients_now_ > 0; }
  std::size_t clients() const { return clients_now_; }
  // Number of events that were dropped because a client was slow, of all clients until now.
  std::uint64_t dropped() const;

  // Returns the number of a new client; empty if there are kMaxClients.
  std::optional<int> Connect();
  void Disconnect(int client);
  // Waits for content and returns it as text of server-sent events, or a comment after `timeout`;
  // empty once the hub is closed and the client has received its events.
  std::optional<std::string> Next(int client, std::chrono::milliseconds timeout);
  // Ends all Next() after the events that wait. Blocks that wait are dropped.
  void Close();

 private:
  using Clock = std::chrono::steady_clock;

  struct Client {
    EventChannel channel;
    std::uint64_t known = 0;     // revision of the scene
    std::uint64_t reported = 0;  // dropped events of which it was informed
    Clock::time_point next_blocks{};
  };

  bool HasContent(const Client& client) const {
    return client.channel.size() > 0 || client.channel.dropped() != client.reported;
  }

  const std::size_t block_bytes_per_second_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, Client> clients_;
  std::map<std::string, ViewEvent> latest_;
  SceneBlocks scene_;
  std::uint64_t dropped_ = 0;  // by clients that are gone
  int next_client_ = 0;
  bool closed_ = false;
  std::atomic<std::size_t> clients_now_ = 0;
};

}  // namespace highwall::apps
