// highwall_ros: SLAM as a node of ROS 1 (docs/ros.md).
#include <cstdio>
#include <exception>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "cli/classic_locale.h"
#include "cli/commands.h"
#include "cli/stop_signals.h"
#include "ros/node.h"
#include "ros/node_options.h"
#include "ros/ros_link.h"

namespace highwall::apps {
namespace {

void PrintError(const std::exception& error) {
  fmt::print(stderr, "highwall_ros: {}\n", OneLine(error.what()));
}

int Main(int argc, char** argv) {
  RosLink::Init(argc, argv);
  if (argc > 1) {
    fmt::print(stderr, "highwall_ros: takes parameters, as _out:=FOLDER, not {}\n",
               OneLine(argv[1]));
    return kExitUsage;
  }
  try {
    const StopSignals signals;
    RosLink link;
    const NodeOptions options = ReadNodeOptions(link.parameters());
    return RunNode(link, options, signals);
  } catch (const IoError& error) {
    PrintError(error);
    return kExitData;
  } catch (const InvalidArgument& error) {
    PrintError(error);
    return kExitData;
  } catch (const std::exception& error) {
    PrintError(error);
    return kExitFailed;
  }
}

}  // namespace
}  // namespace highwall::apps

int main(int argc, char** argv) {
  return highwall::apps::Main(argc, argv);
}
