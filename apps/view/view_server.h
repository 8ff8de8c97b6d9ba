#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "view/view_hub.h"

namespace highwall::apps {

struct ViewServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;         // 0: any free one
  std::string token{};  // required by every request; empty: none
  bool local = true;    // only requests to a local host name are answered
};

// Serves the page of a run, its events and its buttons by HTTP on threads of its own. It reads no
// file: everything it sends is in memory.
class ViewServer {
 public:
  // Applies a button's command; returns false if there is no such command.
  using Command = std::function<bool(std::string_view command)>;

  // hub: must outlive the server. page: HTML. Throws IoError if it cannot listen.
  ViewServer(const ViewServerOptions& options, ViewHub& hub, std::string page, Command command);
  // Closes the hub, ends all connections and waits for them: at most for as long as a client may
  // block.
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  int port() const;
  // Sets the report of the run, an HTML page.
  void SetReport(std::string report);
  // Number of times that the report was fetched.
  int reports_fetched() const;
  bool IsSendingReport() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall::apps
