// main() of every test program. Beside the options of GoogleTest:
//   --source=x_test   the tests that x_test.cc holds, only
//   --apart           each test in a process of its own, forked once the libraries are loaded: what
//                     one of them leaves behind reaches no other
//   --except=A,B      without the tests of the source that have these names (of the test, not its suite)
//   --fast            without statistics over many seeds: tests with a name that ends in "Seeds"
// Exit code 0: all passed; 1: some failed; 77: none failed, some were skipped.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace {

constexpr int kSkipped = 77;

struct Arguments {
  std::string source;
  std::vector<std::string> except;
  bool apart = false;
  bool fast = false;
};

Arguments Parse(int argc, char** argv) {
  constexpr std::string_view kSource = "--source=", kExcept = "--except=";
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word.starts_with(kSource)) {
      arguments.source = word.substr(kSource.size());
    } else if (word.starts_with(kExcept)) {
      std::istringstream names(std::string(word.substr(kExcept.size())));
      for (std::string name; std::getline(names, name, ',');) arguments.except.push_back(name);
    } else if (word == "--apart") {
      arguments.apart = true;
    } else if (word == "--fast") {
      arguments.fast = true;
    } else {
      std::fprintf(stderr, "unknown option %s\n", argv[i]);
      std::exit(1);
    }
  }
  return arguments;
}

// Returns the full names of the tests to run. Exits if the source has no test of a name in `except`,
// which would otherwise exclude nothing once that test is renamed.
std::vector<std::string> TestsOf(const Arguments& arguments) {
  std::vector<std::string> names;
  std::vector<std::string> unknown = arguments.except;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const testing::TestInfo& test = *suite.GetTestInfo(t);
      if (std::filesystem::path(test.file()).stem() != arguments.source) continue;
      std::erase(unknown, test.name());
      if (std::ranges::find(arguments.except, test.name()) != arguments.except.end()) continue;
      if (arguments.fast && std::string_view(test.name()).ends_with("Seeds")) continue;
      names.push_back(std::string(suite.name()) + '.' + test.name());
    }
  }
  for (const std::string& name : unknown) {
    std::fprintf(stderr, "%s.cc has no test %s to except\n", arguments.source.c_str(), name.c_str());
  }
  if (!unknown.empty()) std::exit(1);
  return names;
}

// Results of a child: the failed or skipped tests, with the reasons.
class FailurePrinter : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.passed()) return;
    std::printf("%s:%d: %s\n", result.file_name() != nullptr ? result.file_name() : "",
                result.line_number(), result.message());
    std::fflush(stdout);  // the test may still crash
  }
};

int RunTogether() {
  if (RUN_ALL_TESTS() != 0) return 1;
  return testing::UnitTest::GetInstance()->skipped_test_count() > 0 ? kSkipped : 0;
}

// Returns the exit code of a test that runs in a child. Failures are printed there.
int RunInChild(const std::string& name) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) {
    std::perror("fork");
    return 1;
  }
  if (child == 0) {
    GTEST_FLAG_SET(filter, name);
    std::exit(RunTogether());
  }
  int status = 0;
  while (::waitpid(child, &status, 0) != child) {
    if (errno == EINTR) continue;
    std::perror("waitpid");
    return 1;
  }
  if (WIFSIGNALED(status)) std::printf("ended by signal %d\n", WTERMSIG(status));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

int RunApart(const std::vector<std::string>& names) {
  testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
  delete listeners.Release(listeners.default_result_printer());
  listeners.Append(new FailurePrinter);
  int failed = 0, skipped = 0;
  for (const std::string& name : names) {
    std::printf("[ RUN      ] %s\n", name.c_str());
    const auto begin = std::chrono::steady_clock::now();
    const int code = RunInChild(name);
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
    failed += code != 0 && code != kSkipped;
    skipped += code == kSkipped;
    const char* word = code == 0          ? "[       OK ]"
                       : code == kSkipped ? "[  SKIPPED ]"
                                          : "[  FAILED  ]";
    std::printf("%s %s (%.0f ms)\n", word, name.c_str(), time.count());
  }
  std::printf("%zu tests: %zu passed, %d failed, %d skipped\n", names.size(),
              names.size() - static_cast<std::size_t>(failed + skipped), failed, skipped);
  if (failed > 0) return 1;
  return skipped > 0 ? kSkipped : 0;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const Arguments arguments = Parse(argc, argv);
  if (arguments.source.empty()) return RUN_ALL_TESTS();

  const std::vector<std::string> names = TestsOf(arguments);
  if (names.empty()) {
    std::fprintf(stderr, "this program has no test of %s.cc\n", arguments.source.c_str());
    return 1;
  }
  if (arguments.apart) return RunApart(names);
  std::string filter;
  for (const std::string& name : names) filter += name + ':';
  GTEST_FLAG_SET(filter, filter);
  return RunTogether();
}
