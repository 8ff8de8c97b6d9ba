#pragma once

namespace highwall::apps {

// Lets the threads of this process share one heap. By default the C library gives each thread a
// heap of its own, and each keeps the memory that it once needed. To be called first in main().
// Without effect if the environment states MALLOC_ARENA_MAX.
void LimitHeaps();

// Returns memory that was freed to the operating system. The threads of a run free it in places
// from which the C library would not hand it to the stages that follow.
void ReturnFreeMemory();

// Returns the peak memory of the process [MiB].
double PeakMemoryMib();

// Returns the memory that the process holds now [MiB]; 0 where the system does not state it.
double ResidentMemoryMib();

}  // namespace highwall::apps
