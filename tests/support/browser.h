#pragma once

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/run_program.h"

namespace highwall::testing {

// Debian's chromium without a window, controlled by its DevTools protocol over a pipe. It is ended
// with the object. Throws std::runtime_error if it does not answer within a minute.
class Browser {
 public:
  using json = nlohmann::json;

  static bool IsInstalled() { return RunProgram("chromium", "--version").exit_code == 0; }

  // profile: a folder of its own.
  explicit Browser(const std::filesystem::path& profile) {
    std::array<int, 2> to{}, from{};
    if (::pipe(to.data()) != 0 || ::pipe(from.data()) != 0) throw std::runtime_error("no pipe");
    std::vector<std::string> words = {"chromium",
                                      "--headless",
                                      "--no-sandbox",
                                      "--disable-dev-shm-usage",
                                      "--disable-gpu-sandbox",
                                      "--use-angle=swiftshader",
                                      "--enable-unsafe-swiftshader",
                                      "--hide-scrollbars",
                                      "--window-size=1500,1000",
                                      "--remote-debugging-pipe",
                                      "--user-data-dir=" + profile.string()};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {
      ::setpgid(0, 0);
      ::unsetenv("GLIBC_TUNABLES");
      // Chromium reads from 3 and writes to 4; the ends of the pipes may be these.
      const int in = ::fcntl(to[0], F_DUPFD, 10), out = ::fcntl(from[1], F_DUPFD, 10);
      ::dup2(in, 3);
      ::dup2(out, 4);
      const int nothing = ::open("/dev/null", O_RDWR);
      for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, stream);
      ::execvp(arguments.front(), arguments.data());
      ::_exit(127);
    }
    ::setpgid(process_, process_);
    ::close(to[0]);
    ::close(from[1]);
    to_ = to[1];
    from_ = from[0];
    ::fcntl(to_, F_SETFD, FD_CLOEXEC);
    ::fcntl(from_, F_SETFD, FD_CLOEXEC);
  }
  ~Browser() {
    ::kill(-process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    ::close(to_);
    ::close(from_);
  }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  // Opens a page in a tab of its own, to which the following calls apply.
  void Open(const std::string& url) {
    session_.clear();
    const json target = Call("Target.createTarget", {{"url", "about:blank"}})["targetId"];
    session_ =
        Call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}})["sessionId"];
    for (const char* part : {"Runtime.enable", "Log.enable", "Page.enable"})
      Call(part, json::object());
    Call("Page.navigate", {{"url", url}});
  }
  // Returns the value of an expression in JavaScript.
  json Evaluate(const std::string& expression) {
    const json result = Call(
        "Runtime.evaluate",
        {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}})["result"];
    return result.contains("value") ? result["value"] : json();
  }
  // Waits until an expression is true; returns false after a minute.
  bool WaitFor(const std::string& expression) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < until) {
      if (Evaluate("!!(" + expression + ")") == true) return true;
      ::usleep(20'000);
    }
    return false;
  }
  // Errors of the console and exceptions until now, of all pages.
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  json Call(const std::string& method, const json& parameters) {
    json message = {{"id", ++last_id_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) message["sessionId"] = session_;
    const std::string text = message.dump();
    if (::write(to_, text.c_str(), text.size() + 1) < 0) throw std::runtime_error("browser: ended");
    while (true) {
      const json answer = Read();
      if (answer.value("id", 0) == last_id_) return answer.value("result", json::object());
      Note(answer);
    }
  }
  void Note(const json& event) {
    const std::string method = event.value("method", "");
    const bool is_error =
        method == "Runtime.exceptionThrown" ||
        (method == "Runtime.consoleAPICalled" && event["params"]["type"] == "error") ||
        (method == "Log.entryAdded" && event["params"]["entry"]["level"] == "error");
    if (is_error) errors_.push_back(event["params"].dump());
  }
  // Returns the next message; they end with a zero byte.
  json Read() {
    std::size_t end = 0;
    while ((end = buffer_.find('\0')) == std::string::npos) {
      pollfd ready{from_, POLLIN, 0};
      std::array<char, 65'536> bytes{};
      const ssize_t size =
          ::poll(&ready, 1, 60'000) > 0 ? ::read(from_, bytes.data(), bytes.size()) : -1;
      if (size <= 0) throw std::runtime_error("browser: no answer");
      buffer_.append(bytes.data(), static_cast<std::size_t>(size));
    }
    const json message = json::parse(buffer_.substr(0, end));
    buffer_.erase(0, end + 1);
    return message;
  }

  pid_t process_ = 0;
  int to_ = -1, from_ = -1, last_id_ = 0;
  std::string session_, buffer_;
  std::vector<std::string> errors_;
};

}  // namespace highwall::testing
