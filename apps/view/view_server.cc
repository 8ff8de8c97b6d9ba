#include "view/view_server.h"

#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <httplib.h>
#undef _res  // of resolv.h, and a name in Eigen

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

using httplib::Request;
using httplib::Response;
using Text = std::shared_ptr<const std::string>;

constexpr std::size_t kThreads = ViewHub::kMaxClients + 8;  // events, and short requests
constexpr int kTimeout = 2;                                 // [s] that a client may block a thread
constexpr int kSendBuffer = 256 << 10;                      // [bytes] of a connection
constexpr std::chrono::milliseconds kEventTimeout(1000);        // then vanished clients are noticed
// A page of another site cannot send it, since that needs a permission which is never given.
constexpr const char* kButtonHeader = "X-Highwall-Button";

// Compares in a time that does not depend on where they differ.
bool IsEqual(std::string_view a, std::string_view b) {
  unsigned differs = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    differs |= static_cast<unsigned>(a[i] ^ b[i]);
  }
  return differs == 0;
}

// Whether a request was sent to a name of this machine itself: another name that a site has made
// to point here is refused.
bool IsLocal(const std::string& host) {
  const std::string name =
      host.starts_with('[') ? host.substr(0, host.find(']') + 1) : host.substr(0, host.find(':'));
  return name == "localhost" || name == "[::1]" || name.starts_with("127.");
}

void Refuse(Response& response, int status, const char* why) {
  response.status = status;
  response.set_content(why, "text/plain");
}

// As it is: a content of known length is not compressed. on_end: called at the end, with whether it
// was sent.
void Send(const Text& text, Response& response, std::function<void(bool)> on_end = nullptr) {
  response.set_content_provider(
      text->size(), "text/html; charset=utf-8",
      [text](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(text->data() + offset, length);
      },
      std::move(on_end));
}

void SetSocketOptions(socket_t socket) {
  const int yes = 1;  // a port in use is refused: it must not be shared
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
}

}  // namespace

struct ViewServer::Impl {
  Impl(const ViewServerOptions& o, ViewHub& h, std::string p, Command c)
      : options(o),
        hub(h),
        page(std::make_shared<const std::string>(std::move(p))),
        command(std::move(c)) {}

  // Returns whether the request was refused.
  bool Refuses(const Request& request, Response& response) const;
  void SetHandlers();
  void SendEvents(Response& response);
  void SendReport(Response& response);

  const ViewServerOptions options;
  ViewHub& hub;
  const Text page;
  const Command command;
  std::mutex mutex;
  Text report;                                // guarded by the mutex
  std::atomic<int> fetched = 0, sending = 0;  // reports
  int port = 0;
  httplib::Server server;
  std::jthread listener;
};

bool ViewServer::Impl::Refuses(const Request& request, Response& response) const {
  if (options.local && !IsLocal(request.get_header_value("Host"))) {
    Refuse(response, 403, "only for this machine\n");
    return true;
  }
  if (!options.token.empty() && !IsEqual(request.get_param_value("token"), options.token)) {
    Refuse(response, 403, "the token is missing or wrong: use the address that highwall printed\n");
    return true;
  }
  return false;
}

void ViewServer::Impl::SendEvents(Response& response) {
  const std::optional<int> client = hub.Connect();
  if (!client) return Refuse(response, 503, "too many clients\n");
  response.set_header("Cache-Control", "no-store");
  response.set_chunked_content_provider(
      "text/event-stream",
      [this, id = *client](std::size_t, httplib::DataSink& sink) {
        const std::optional<std::string> text = hub.Next(id, kEventTimeout);
        if (text) return sink.write(text->data(), text->size());
        sink.done();
        return true;
      },
      [this, id = *client](bool) { hub.Disconnect(id); });
}

void ViewServer::Impl::SendReport(Response& response) {
  Text text;
  {
    const std::lock_guard lock(mutex);
    text = report;
  }
  if (!text) return Refuse(response, 404, "the run has no report yet\n");
  ++sending;
  Send(text, response, [this](bool sent) {
    fetched += sent ? 1 : 0;
    --sending;
  });
}

void ViewServer::Impl::SetHandlers() {
  server.set_pre_routing_handler([this](const Request& request, Response& response) {
    using Result = httplib::Server::HandlerResponse;
    return Refuses(request, response) ? Result::Handled : Result::Unhandled;
  });
  server.Get("/", [this](const Request&, Response& response) { Send(page, response); });
  server.Get("/events", [this](const Request&, Response& response) { SendEvents(response); });
  server.Get("/report", [this](const Request&, Response& response) { SendReport(response); });
  server.Post("/button/([a-z]+)", [this](const Request& request, Response& response) {
    if (!request.has_header(kButtonHeader)) return Refuse(response, 403, "not from the page\n");
    if (!command(request.matches[1].str())) return Refuse(response, 404, "no such button\n");
    response.status = 204;
  });
}

ViewServer::ViewServer(const ViewServerOptions& options, ViewHub& hub, std::string page,
                       Command command)
    : impl_(std::make_unique<Impl>(options, hub, std::move(page), std::move(command))) {
  httplib::Server& server = impl_->server;
  server.new_task_queue = [] { return std::make_unique<httplib::ThreadPool>(kThreads).release(); };
  server.set_socket_options(SetSocketOptions);
  server.set_tcp_nodelay(true);
  server.set_read_timeout(kTimeout);
  server.set_write_timeout(kTimeout);
  server.set_payload_max_length(1024);
  impl_->SetHandlers();
  const std::string& address = options.address;
  impl_->port = options.port;
  if (options.port == 0) {
    impl_->port = server.bind_to_any_port(address);
  } else if (!server.bind_to_port(address, options.port)) {
    impl_->port = -1;
  }
  if (impl_->port <= 0) {
    throw IoError(address + ":" + std::to_string(options.port),
                  "cannot be listened on: the port is in use, or the address is not of this "
                  "machine; choose another --view=PORT or --view-address");
  }
  impl_->listener = std::jthread([&server] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::yield();  // stop() has no effect before
}

ViewServer::~ViewServer() {
  impl_->hub.Close();
  // The server ends connections at once: clients that read receive their last events before.
  for (int i = 0; i < 50 && impl_->hub.HasClients(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  impl_->server.stop();
}

int ViewServer::port() const {
  return impl_->port;
}

void ViewServer::SetReport(std::string report) {
  const std::lock_guard lock(impl_->mutex);
  impl_->report = std::make_shared<const std::string>(std::move(report));
}

int ViewServer::reports_fetched() const {
  return impl_->fetched;
}

bool ViewServer::IsSendingReport() const {
  return impl_->sending > 0;
}

}  // namespace highwall::apps
