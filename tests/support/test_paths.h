#pragma once

// Where the tests find programs and data: absolute paths, which a source that the build generates
// defines, so that no test is compiled anew in another folder. Empty: not part of this build.
namespace highwall::testing {

extern const char* const kSourceFolder;
extern const char* const kSharedData;  // may not exist
extern const char* const kHighwallProgram;
extern const char* const
    kDecimalComma;  // a library to be preloaded: support/decimal_comma_preload.cc
extern const char* const kNetworkPointsExample;
extern const char* const kBenchConditions;
extern const char* const kBenchImu;
extern const char* const kBenchInertial;
extern const char* const kBenchLines;
extern const char* const kBenchLoops;
extern const char* const kBenchOctomap;
extern const char* const kBenchPoints;
extern const char* const kBenchRelocation;
extern const char* const kBenchRobustness;
extern const char* const kBenchTum;

}  // namespace highwall::testing
