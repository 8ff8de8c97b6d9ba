#pragma once

#include <chrono>
#include <utility>

#include <highwall/internal/processor_time.h>
#include <highwall/internal/run_profile.h>

namespace [[gnu::visibility("default")]] highwall {

// Measures the wall time of a stage, from its construction to its end, for the statistics of a run
// and for its trace. Where neither asks for it, no clock is read.
class StageTimer {
 public:
  // profile: null: none. stage: a literal. milliseconds: the time is added to it at the end; null:
  // nowhere.
  StageTimer(RunProfile* profile, const char* stage, double* milliseconds = nullptr)
      : profile_(profile != nullptr && profile->is_tracing() ? profile : nullptr),
        stage_(stage),
        milliseconds_(milliseconds) {
    if (profile_ != nullptr || milliseconds_ != nullptr) begin_ = RunProfile::Clock::now();
  }
  ~StageTimer() { Stop(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

  // Ends the stage before the object ends; only the first call counts.
  void Stop() {
    if (profile_ == nullptr && milliseconds_ == nullptr) return;
    const RunProfile::Clock::time_point end = RunProfile::Clock::now();
    if (double* const milliseconds = std::exchange(milliseconds_, nullptr)) {
      *milliseconds += std::chrono::duration<double, std::milli>(end - begin_).count();
    }
    if (RunProfile* const profile = std::exchange(profile_, nullptr)) {
      profile->AddSpan(stage_, begin_, end);
    }
  }

 private:
  RunProfile* profile_;  // null: no trace
  const char* const stage_;
  double* milliseconds_;
  RunProfile::Clock::time_point begin_{};
};

// Measures the decoding of an image on the calling thread, and counts its processor time as such.
class DecodingTimer {
 public:
  // profile: null: none.
  explicit DecodingTimer(RunProfile* profile) : profile_(profile), stage_(profile, "decoding") {
    if (profile_ != nullptr) begin_ = ThreadProcessorSeconds();
  }
  ~DecodingTimer() {
    if (profile_ != nullptr) profile_->AddDecoding(ThreadProcessorSeconds() - begin_);
  }
  DecodingTimer(const DecodingTimer&) = delete;
  DecodingTimer& operator=(const DecodingTimer&) = delete;

 private:
  RunProfile* const profile_;
  const StageTimer stage_;
  double begin_ = 0.0;  // [s]
};

}  // namespace highwall
