// The server of the live view, by HTTP and by what is not HTTP.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <httplib.h>
#undef _res  // of resolv.h, and a name in Eigen

#include <highwall/core/error.h>

#include "view/view_hub.h"
#include "view/view_server.h"

namespace highwall::apps::view_server_test {
namespace {

// A connection without a protocol, closed with the object.
class RawConnection {
 public:
  explicit RawConnection(int port, int receive_buffer = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~RawConnection() { ::close(socket_); }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  bool connected() const { return connected_; }
  void Send(const std::string& bytes) const {
    (void)!::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

 private:
  int socket_ = -1;
  bool connected_ = false;
};

// Receives events until it has seen `last`.
std::string Receive(int port, const std::string& path, const std::string& last) {
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(20);
  std::string received;
  client.Get(path, [&](const char* data, std::size_t size) {
    received.append(data, size);
    return received.find(last) == std::string::npos;
  });
  return received;
}

class Server : public ::testing::Test {
 protected:
  std::unique_ptr<ViewServer> Serve(const std::string& token = "", bool local = true) {
    return std::make_unique<ViewServer>(ViewServerOptions{.token = token, .local = local}, hub_,
                                        "<html>page</html>", [this](std::string_view command) {
                                          const std::lock_guard lock(mutex_);
                                          pressed_ += std::string(command) + " ";
                                          return command != "dance";
                                        });
  }
  std::string pressed() {
    const std::lock_guard lock(mutex_);
    return pressed_;
  }

  ViewHub hub_;
  std::mutex mutex_;
  std::string pressed_;
};

TEST_F(Server, SendsThePageAndItsEventsToTwoClients) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", server->port());
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->body, "<html>page</html>");
  hub_.Post("frame", "1");
  std::string first, second;
  {
    std::jthread one([&] { first = Receive(server->port(), "/events", "data: 2\n"); });
    std::jthread two([&] { second = Receive(server->port(), "/events", "data: 2\n"); });
    while (hub_.clients() < 2) std::this_thread::yield();
    hub_.Post("frame", "2");
  }
  for (const std::string& received : {first, second}) {
    EXPECT_NE(received.find("event: frame\ndata: 1\n\n"), std::string::npos) << received;
    EXPECT_NE(received.find("event: frame\ndata: 2\n\n"), std::string::npos);
  }
}

TEST_F(Server, AnswersOnlyWhoKnowsTheToken) {
  const auto server = Serve("secret", false);
  httplib::Client client("127.0.0.1", server->port());
  for (const char* path : {"/", "/events", "/report", "/?token=", "/?token=secre",
                           "/?token=secrets", "/?token=SECRET", "/nowhere"}) {
    const auto answer = client.Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, 403) << path;
    EXPECT_EQ(answer->body.find("page"), std::string::npos);
  }
  EXPECT_EQ(client.Post("/button/stop", {{"X-Highwall-Button", "1"}}, "", "text/plain")->status,
            403);
  EXPECT_EQ(pressed(), "");
  EXPECT_EQ(client.Get("/?token=secret")->status, 200);
  EXPECT_EQ(
      client.Post("/button/stop?token=secret", {{"X-Highwall-Button", "1"}}, "", "text/plain")
          ->status,
      204);
  EXPECT_EQ(pressed(), "stop ");
}

// A page of another site can make a browser send requests here, but not with these headers.
TEST_F(Server, RefusesWhatOtherSitesSend) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", server->port());
  EXPECT_EQ(client.Post("/button/stop", "", "text/plain")->status, 403);
  EXPECT_EQ(client.Get("/button/stop")->status, 404);
  EXPECT_EQ(client.Get("/", httplib::Headers{{"Host", "example.org"}})->status, 403);
  EXPECT_EQ(client.Get("/", httplib::Headers{{"Host", "localhost:1"}})->status, 200);
  EXPECT_EQ(client.Post("/button/dance", {{"X-Highwall-Button", "1"}}, "", "text/plain")->status,
            404);
  EXPECT_EQ(pressed(), "dance ");
}

TEST_F(Server, ReadsNoFile) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", server->port());
  for (const char* path : {"/etc/passwd", "/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
                           "//etc/passwd", "/events/../../etc/passwd", "/run.json"}) {
    const auto answer = client.Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_GE(answer->status, 400) << path;
    EXPECT_EQ(answer->body.find("root:"), std::string::npos);
  }
}

TEST_F(Server, SendsTheReportOnceThereIsOne) {
  const auto server = Serve();
  httplib::Client client("127.0.0.1", server->port());
  EXPECT_EQ(client.Get("/report")->status, 404);
  server->SetReport(std::string(3'000'000, 'r'));
  EXPECT_EQ(client.Get("/report")->body.size(), 3'000'000U);
  while (server->reports_fetched() == 0) std::this_thread::yield();
}

// By state: its queue stays bounded and drops, whatever the time.
TEST_F(Server, AClientThatNeverReadsHoldsUpNothing) {
  const auto server = Serve();
  const RawConnection silent(server->port(), 4096);
  silent.Send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (hub_.clients() < 1) std::this_thread::yield();
  const std::string data(100'000, 'x');
  for (int i = 0; i < 500; ++i) hub_.Post("frame", data);  // far more than sockets hold
  EXPECT_GT(hub_.dropped(), 400U);
  const std::string other = Receive(server->port(), "/events", "xxx\n\n");
  EXPECT_NE(other.find("event: frame\n"), std::string::npos) << "another client is served";
}

TEST_F(Server, AClientThatVanishesIsForgotten) {
  const auto server = Serve();
  {
    const RawConnection gone(server->port());
    gone.Send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    while (hub_.clients() < 1) std::this_thread::yield();
  }
  while (hub_.clients() > 0) hub_.Post("frame", "1");
  EXPECT_FALSE(hub_.HasClients());
}

TEST_F(Server, NonsenseBreaksNothing) {
  const auto server = Serve();
  std::mt19937 random(7);
  const std::vector<std::string> starts = {
      "",
      "GET ",
      "GET / HTTP/1.1\r\n",
      "POST /button/stop HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n",
      "GET /events?token=%zz HTTP/1.1\r\nHost: localhost\r\n",
      "\r\n\r\n"};
  for (int i = 0; i < 400; ++i) {
    std::string bytes = starts[random() % starts.size()];
    const std::size_t size = random() % 3000;
    for (std::size_t n = 0; n < size; ++n) bytes += static_cast<char>(random() % 256);
    const RawConnection connection(server->port());
    connection.Send(bytes);
  }
  httplib::Client client("127.0.0.1", server->port());
  client.set_connection_timeout(60);
  client.set_read_timeout(60);
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->body, "<html>page</html>");
  EXPECT_EQ(pressed(), "");
}

TEST_F(Server, APortInUseIsAnError) {
  const auto server = Serve();
  EXPECT_THROW(
      ViewServer({.port = server->port()}, hub_, "", [](std::string_view) { return true; }),
      IoError);
  EXPECT_THROW(
      ViewServer({.address = "203.0.113.7"}, hub_, "", [](std::string_view) { return true; }),
      IoError);
}

TEST_F(Server, EndsWhileClientsWait) {
  auto server = Serve();
  std::string received;
  std::jthread client(
      [&, port = server->port()] { received = Receive(port, "/events", "data: last\n"); });
  while (hub_.clients() < 1) std::this_thread::yield();
  hub_.Post("ended", "last");
  server.reset();
  client.join();
  EXPECT_NE(received.find("data: last"), std::string::npos);
}

}  // namespace
}  // namespace highwall::apps::view_server_test
