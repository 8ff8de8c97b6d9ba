#include "run/trace_file.h"

#include <chrono>
#include <cstddef>
#include <string>
#include <system_error>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

constexpr int kProcess = 1;  // the only one of a trace

// Microseconds with all digits of nanoseconds, so that the stages nest as they did.
std::string Microseconds(std::chrono::nanoseconds time) {
  return fmt::format("{}.{:03}", time.count() / 1000, time.count() % 1000);
}

std::string Quoted(const std::string& name) {
  return nlohmann::json(name).dump();
}

// "M": an event that names a thread or its place among the others.
std::string NameEvent(std::size_t lane, const std::string& name) {
  return fmt::format(
      R"({{"name":"thread_name","ph":"M","pid":{},"tid":{},"args":{{"name":{}}}}},)"
      "\n"
      R"({{"name":"thread_sort_index","ph":"M","pid":{},"tid":{},"args":{{"sort_index":{}}}}})",
      kProcess, lane, Quoted(name), kProcess, lane, lane);
}

// "X": a stage with beginning and duration.
std::string StageEvent(const RunProfile::Span& span) {
  return fmt::format(R"({{"name":{},"ph":"X","pid":{},"tid":{},"ts":{},"dur":{}}})",
                     Quoted(span.stage), kProcess, span.lane, Microseconds(span.begin),
                     Microseconds(span.duration));
}

}  // namespace

void WriteTrace(const std::filesystem::path& path, const RunProfile::Trace& trace) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder, "cannot be made: " + error.message());
  AtomicFile file(path);
  const char* separator = "[\n";
  const auto write = [&](const std::string& event) {
    file.stream() << separator << event;
    separator = ",\n";
  };
  for (std::size_t lane = 0; lane < trace.lanes.size(); ++lane) {
    write(NameEvent(lane, trace.lanes[lane]));
  }
  for (const RunProfile::Span& span : trace.spans) write(StageEvent(span));
  file.stream() << (trace.lanes.empty() ? "[]\n" : "\n]\n");
  file.Commit();
}

}  // namespace highwall::apps
