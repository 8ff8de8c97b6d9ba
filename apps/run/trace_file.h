#pragma once

#include <filesystem>

#include <highwall/internal/run_profile.h>

namespace highwall::apps {

// Writes a trace in Chrome's format, for chrome://tracing and ui.perfetto.dev: a JSON array with
// the name of each thread and its stages as complete events, in microseconds since the beginning of
// the run. Atomic; a missing folder is made. Throws IoError.
void WriteTrace(const std::filesystem::path& path, const RunProfile::Trace& trace);

}  // namespace highwall::apps
