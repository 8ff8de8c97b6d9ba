#include "ros/node_options.h"

#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>
#include <highwall/internal/did_you_mean.h>
#include <highwall/internal/number_text.h>

#include "run/imu_choice.h"

namespace highwall::apps {
namespace {

using Reader = std::function<void(const std::string& text)>;

constexpr std::string_view kSet = "set.";  // before the path of a setting

Reader Text(std::string* value) {
  return [value](const std::string& text) { *value = text; };
}

Reader Flag(bool* value) {
  return [value](const std::string& text) {
    if (text != "true" && text != "false") throw InvalidArgument("must be true or false");
    *value = text == "true";
  };
}

// most: inclusive; least: exclusive.
Reader Number(double* value, double least, double most) {
  return [=](const std::string& text) {
    const std::optional<double> number = ReadNumber<double>(text);
    if (!number || !(*number > least && *number <= most)) {
      throw InvalidArgument("must be a number above " + NumberText(least) + ", at most " +
                            NumberText(most));
    }
    *value = *number;
  };
}

Reader Count(std::size_t* value) {
  return [value](const std::string& text) {
    constexpr std::size_t kMost = 10'000;
    const std::optional<std::size_t> number = ReadNumber<std::size_t>(text);
    if (!number || *number < 1 || *number > kMost) {
      throw InvalidArgument("must be a whole number from 1 to 10000");
    }
    *value = *number;
  };
}

Reader Imu(std::string* value) {
  return [value](const std::string& text) {
    ReadImuChoice(text);
    *value = text;
  };
}

std::map<std::string, Reader> Readers(NodeOptions* options) {
  SlamArguments* const slam = &options->slam;
  CameraStreamOptions* const camera = &options->camera;
  RosFrames* const frames = &options->link.frames;
  return {
      {"out", Text(&slam->out)},
      {"config", Text(&slam->config)},
      {"load_map", Text(&slam->load_map)},
      {"save_map", Text(&slam->save_map)},
      {"settings", Text(&slam->settings)},
      {"imu", Imu(&slam->imu)},
      {"resolution", Number(&slam->resolution, 0.0, 10.0)},
      {"max_pair_difference", Number(&camera->max_stamp_difference, 0.0, 1.0)},
      {"deterministic", Flag(&slam->deterministic)},
      {"no_map", Flag(&slam->no_map)},
      {"no_loops", Flag(&slam->no_loops)},
      {"adjust_all", Flag(&slam->adjust_all)},
      {"localize", Flag(&slam->localize)},
      {"overwrite", Flag(&slam->overwrite)},
      {"sensor", Text(&options->sensor)},
      {"depth_factor", Number(&camera->depth_factor, 0.0, 1e6)},
      {"queue", Count(&camera->queue)},
      {"imu_lead", Number(&options->imu_lead, 0.0, 1.0)},
      {"rectified", Flag(&options->link.rectified)},
      {"map_frame", Text(&frames->map)},
      {"odom_frame", Text(&frames->odom)},
      {"base_frame", Text(&frames->base)},
      {"covariances", Flag(&slam->covariances)},
      {"publish_period", Number(&options->publish_period, 0.0, 3600.0)},
  };
}

void RequireConsistent(const NodeOptions& options) {
  const SlamArguments& slam = options.slam;
  if (slam.out.empty()) throw InvalidArgument("~out names the folder for the results: set it");
  if (slam.localize && slam.load_map.empty()) {
    throw InvalidArgument("~localize needs a map: set ~load_map");
  }
  if (slam.localize && !slam.save_map.empty()) {
    throw InvalidArgument("~localize changes no map: leave ~save_map out");
  }
  if (FindSensorProfile(options.sensor) == nullptr) {
    throw InvalidArgument("~sensor is " + options.sensor + ", must be one of " +
                          SensorProfileList());
  }
}

}  // namespace

NodeOptions ReadNodeOptions(const Parameters& parameters) {
  NodeOptions options;
  const std::map<std::string, Reader> readers = Readers(&options);
  for (const auto& [path, text] : parameters) {
    if (path.starts_with(kSet)) {
      options.slam.set.push_back(path.substr(kSet.size()) + "=" + text);
      continue;
    }
    const auto reader = readers.find(path);
    if (reader == readers.end()) {
      std::vector<std::string> known;
      for (const auto& [name, unused] : readers) known.push_back(name);
      throw InvalidArgument("there is no parameter ~" + path + DidYouMean(path, known));
    }
    try {
      reader->second(text);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("~" + path + " is '" + text + "': " + error.what());
    }
  }
  RequireConsistent(options);
  options.slam.live = !options.slam.deterministic;
  options.link.imu = ReadImuChoice(options.slam.imu).has_value();
  MakeOptions(options.slam);  // throws for a setting
  return options;
}

}  // namespace highwall::apps
