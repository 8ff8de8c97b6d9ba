#pragma once

#include <string>

#include "run/slam_arguments.h"
#include "run/slam_run.h"

namespace highwall::apps {

// Prints what a run has estimated of its sensors to standard error. command: "slam" or "live".
void WarnOfSensors(const std::string& command, const SlamRun& run, double depth_factor);

// Prints a run for people to standard output. has_truth: a readable ground truth exists. memory: as
// in run.json [MiB].
void PrintSummary(const SlamRun& run, const SlamArguments& arguments, bool has_truth,
                  double memory);

}  // namespace highwall::apps
