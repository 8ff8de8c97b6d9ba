#pragma once

// OpenMP, if the process contains it: Debian's CHOLMOD does. No OpenMP is needed to build Highwall.
extern "C" {
[[gnu::weak]] int omp_get_max_active_levels();
[[gnu::weak]] void omp_set_max_active_levels(int levels);
}

namespace highwall::internal {

// During its lifetime parallel regions of OpenMP that its thread enters have one thread. CHOLMOD
// starts four for each supernode, whatever the number of processors: with the small supernodes of a
// pose graph, waking them takes longer than their work, and they keep other threads from running.
// The limit is one of the calling thread (libgomp since GCC 12).
class OneOpenMpThread {
 public:
  // limits: false: does nothing.
  explicit OneOpenMpThread(bool limits)
      : limits_(limits && omp_get_max_active_levels != nullptr &&
                omp_set_max_active_levels != nullptr),
        before_(limits_ ? omp_get_max_active_levels() : 0) {
    if (limits_) omp_set_max_active_levels(0);
  }
  ~OneOpenMpThread() {
    if (limits_) omp_set_max_active_levels(before_);
  }
  OneOpenMpThread(const OneOpenMpThread&) = delete;
  OneOpenMpThread& operator=(const OneOpenMpThread&) = delete;

 private:
  const bool limits_;
  const int before_;
};

}  // namespace highwall::internal
