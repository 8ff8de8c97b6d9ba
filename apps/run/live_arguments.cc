#include "run/live_arguments.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "cli/option_checks.h"

namespace highwall::apps {
namespace {

constexpr double kLongestRun = 1e6;  // [s]

CLI::Validator KnownCamera() {
  return CLI::Validator(
      [](const std::string& choice) -> std::string {
        if (ReadCameraChoice(choice).kind == "openni2") return "";
        return "must be openni2, openni2:URI or openni2:FILE.oni";
      },
      "");
}

}  // namespace

CameraChoice ReadCameraChoice(const std::string& choice) {
  const std::size_t colon = choice.find(':');
  if (colon == std::string::npos) return {choice, ""};
  return {choice.substr(0, colon), choice.substr(colon + 1)};
}

void AddLiveOptions(CLI::App* command, LiveArguments* arguments) {
  SlamArguments* const slam = &arguments->slam;
  slam->live = true;
  CLI::Option* camera =
      command
          ->add_option("--camera", arguments->camera,
                       "openni2: the first camera that OpenNI 2 finds, openni2:URI: one of --list, "
                       "openni2:FILE.oni: a recording as a camera")
          ->type_name("CAMERA")
          ->required()
          ->check(KnownCamera());
  command->add_option(
      "--config", slam->config,
      "tum1, tum2, tum3 or a calibration file: the calibration (default: the field of "
      "view that the camera states)");
  command
      ->add_option("--record", arguments->record,
                   "Record what the camera delivers to this new folder: --dataset of highwall slam")
      ->check(NotEmpty());
  command
      ->add_option("--seconds", arguments->seconds,
                   "End the run after this time [s] (default: when it is stopped)")
      ->check(Between(1e-3, kLongestRun));
  AddRunOptions(command, slam, {camera});
  CLI::Option* out = command->get_option("--out");
  command->add_flag_callback(
      "--list",
      [arguments, camera, out] {
        arguments->list = true;
        camera->required(false);
        out->required(false);
      },
      "List the cameras that are connected, and exit");
}

}  // namespace highwall::apps
