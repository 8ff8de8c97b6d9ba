#pragma once

#include <chrono>
#include <cstddef>
#include <ctime>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <highwall/internal/processor_time.h>

namespace [[gnu::visibility("default")]] highwall {

// Records where the time of a run goes: the processor time of its threads and, if it traces, the
// stages that they run through. It must outlive everything that it is given to. All functions may
// be called from any thread.
class RunProfile {
 public:
  using Clock = std::chrono::steady_clock;

  // [s] Processor time, user and system time together, since the profile was made.
  struct ProcessorSeconds {
    double process = 0.0;  // of all threads
    // By name, of the threads that run and those that have ended. Their sum is at most that of the
    // process; the rest belongs to threads that are not registered, such as those of OpenCV.
    std::map<std::string, double> threads;
    double decoding = 0.0;  // of images, on whichever thread
  };

  // A stage on one of the lanes of a trace, in time since the profile was made.
  struct Span {
    std::size_t lane = 0;
    const char* stage = "";
    std::chrono::nanoseconds begin{}, duration{};
  };
  struct Trace {
    // Names of the lanes. Threads of one name share a lane, except those that run side by side.
    std::vector<std::string> lanes;
    std::vector<Span> spans;  // in the order of their ends
  };

  explicit RunProfile(bool is_tracing = false) : is_tracing_(is_tracing) {}
  RunProfile(const RunProfile&) = delete;
  RunProfile& operator=(const RunProfile&) = delete;

  bool is_tracing() const { return is_tracing_; }
  ProcessorSeconds processor_seconds() const;
  // Empty if the profile does not trace. Stages that have not ended are left out.
  Trace trace() const;

  // Records a stage of the calling thread if that is registered (ProfiledThread). stage: a literal.
  // A stage for which there is no memory is left out. Prefer StageTimer.
  void AddSpan(const char* stage, Clock::time_point begin, Clock::time_point end) noexcept;
  void AddDecoding(double seconds);

 private:
  friend class ProfiledThread;

  // A registered thread, or one that has ended if it is not active.
  struct Lane {
    std::string name;
    bool is_active = false;
    std::thread::id thread{};
    clockid_t clock{};
    double begin = 0.0;  // [s] of the clock, when the thread was registered
    double ended = 0.0;  // [s] processor time of the threads before
  };

  std::size_t Enter(const char* name);
  void Leave(std::size_t lane);

  const bool is_tracing_;
  const Clock::time_point start_ = Clock::now();
  const double process_start_ = ProcessProcessorSeconds();
  mutable std::mutex mutex_;  // protects all members below
  std::vector<Lane> lanes_;
  std::vector<Span> spans_;
  double decoding_ = 0.0;
};

// Priority of a thread where threads compete for the processors.
enum class ThreadPriority {
  kNormal,
  // Below kNormal: for work that may finish later, so that frames do not.
  kBackground,
};

// Name of a thread, the profile that it is registered in, and its priority.
struct ThreadLabel {
  const char* name = "highwall";  // a literal of at most 15 characters
  RunProfile* profile = nullptr;  // null: none; must outlive the thread
  ThreadPriority priority = ThreadPriority::kNormal;
};

// Gives the calling thread the name of its label, for debuggers and top, and its priority.
void SetUpThread(const ThreadLabel& label);

// Registers the calling thread in the profile of the label, if there is one, as long as the object
// exists; a thread must not be registered twice at the same time.
class ProfiledThread {
 public:
  explicit ProfiledThread(const ThreadLabel& label);
  ~ProfiledThread();
  ProfiledThread(const ProfiledThread&) = delete;
  ProfiledThread& operator=(const ProfiledThread&) = delete;

 private:
  RunProfile* const profile_;
  const std::size_t lane_;
};

}  // namespace highwall
