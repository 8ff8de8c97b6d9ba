#pragma once

// HIGHWALL_TARGET_CLONES("avx2", "default") before a function compiles it once for each instruction
// set; the loader selects the best version for the processor. For loops over raw arrays, never for
// functions that take Eigen's types (docs/conventions.md, the alignment trap).
//
// Under ThreadSanitizer there is one version only: the compiler instruments the resolvers too, and
// the loader calls them before the sanitizer's runtime has started.
#if defined(__SANITIZE_THREAD__)
#define HIGHWALL_TARGET_CLONES(...)
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define HIGHWALL_TARGET_CLONES(...)
#endif
#endif

#ifndef HIGHWALL_TARGET_CLONES
#define HIGHWALL_TARGET_CLONES(...) [[gnu::target_clones(__VA_ARGS__)]]
#endif
