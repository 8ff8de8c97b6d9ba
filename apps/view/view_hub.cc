#include "view/view_hub.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace highwall::apps {
namespace {

constexpr std::size_t kBlockBytes = 64 << 10;  // of the blocks that are sent at once

void Append(const std::string& name, const std::string& data, std::string* text) {
  *text += "event: ";
  *text += name;
  *text += "\ndata: ";
  *text += data;
  *text += "\n\n";
}

}  // namespace

void ViewHub::Post(const std::string& name, std::string data) {
  const ViewEvent event{name, std::make_shared<const std::string>(std::move(data))};
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    latest_[name] = event;
    for (auto& [id, client] : clients_) client.channel.Push(event);
  }
  changed_.notify_all();
}

void ViewHub::SetBlock(const std::string& key, std::string data) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    scene_.Set(key, std::move(data));
  }
  changed_.notify_all();
}

void ViewHub::RemoveBlocks(const std::string& prefix) {
  const std::lock_guard lock(mutex_);
  scene_.Remove(prefix);
}

std::uint64_t ViewHub::dropped() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t dropped = dropped_;
  for (const auto& [id, client] : clients_) dropped += client.channel.dropped();
  return dropped;
}

std::optional<int> ViewHub::Connect() {
  const std::lock_guard lock(mutex_);
  if (closed_ || clients_.size() >= kMaxClients) return std::nullopt;
  Client& client = clients_[next_client_];
  for (const auto& [name, event] : latest_) client.channel.Push(event);
  clients_now_ = clients_.size();
  return next_client_++;
}

void ViewHub::Disconnect(int id) {
  const std::lock_guard lock(mutex_);
  const auto client = clients_.find(id);
  if (client == clients_.end()) return;
  dropped_ += client->second.channel.dropped();
  clients_.erase(client);
  clients_now_ = clients_.size();
}

std::optional<std::string> ViewHub::Next(int id, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  const auto found = clients_.find(id);
  if (found == clients_.end()) return std::nullopt;
  Client& client = found->second;
  const Clock::time_point until = Clock::now() + timeout;
  for (Clock::time_point now = Clock::now(); !closed_ && !HasContent(client); now = Clock::now()) {
    const bool blocks = scene_.HasAfter(client.known);
    if ((blocks && now >= client.next_blocks) || now >= until) break;
    changed_.wait_until(lock, blocks ? std::min(until, client.next_blocks) : until);
  }
  std::vector<ViewEvent> events;
  while (std::optional<ViewEvent> event = client.channel.Pop()) events.push_back(std::move(*event));
  if (closed_ && events.empty()) return std::nullopt;
  std::vector<SceneBlocks::Text> blocks;
  if (!closed_ && Clock::now() >= client.next_blocks) {
    blocks = scene_.After(&client.known, kBlockBytes);
    std::size_t bytes = 0;
    for (const auto& block : blocks) bytes += block->size();
    client.next_blocks =
        Clock::now() + std::chrono::microseconds(1'000'000 * bytes / block_bytes_per_second_);
  }
  const bool informs = client.channel.dropped() != client.reported;
  client.reported = client.channel.dropped();
  const std::uint64_t dropped = client.reported;
  lock.unlock();

  std::string text;
  for (const ViewEvent& event : events) Append(event.name, *event.data, &text);
  for (const auto& block : blocks) Append("block", *block, &text);
  if (informs) Append("dropped", std::to_string(dropped), &text);
  return text.empty() ? ":\n\n" : text;
}

void ViewHub::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

}  // namespace highwall::apps
