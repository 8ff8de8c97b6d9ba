#include "bench_main.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <exception>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "cli/classic_locale.h"
#include "cli/option_checks.h"
#include "cli/stop_signals.h"
#include "files/json_text.h"

namespace highwall::bench {

int RunBench(CLI::App& app, int argc, char** argv, const std::function<void()>& run) {
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return fmt::format("{}: {} (see --help)\n", failed->get_name(), error.what());
  });
  try {
    const apps::ClassicLocale classic;
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;  // --help arrives here too
  }
  try {
    run();
    return 0;
  } catch (const apps::StoppedBySignal& stopped) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), stopped.what());
    return apps::ExitCodeOf(stopped.signal());
  } catch (const IoError& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: failed: {}\n", app.get_name(), error.what());
    return 3;
  }
}

int RunBench(const BenchName& name, int argc, char** argv,
             const std::function<void(CLI::App&)>& add_options, const std::function<void()>& run) {
  CLI::App app(name.about, name.binary);
  add_options(app);
  return RunBench(app, argc, argv, run);
}

CLI::Option* AddList(CLI::App& app, const std::string& name, std::vector<std::string>& chosen,
                     const std::vector<std::string>& known, const std::string& remark) {
  const std::string help = fmt::format("{}; separated by commas{}", fmt::join(known, ", "), remark);
  return app.add_option(name, chosen, help)
      ->delimiter(',')
      ->check(apps::OneOf(known).description(""));
}

void PrintFigures(const nlohmann::ordered_json& report, bool json, int width) {
  if (json) {
    fmt::print("{}\n", apps::JsonText(report));
    return;
  }
  const nlohmann::ordered_json flat = report.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    fmt::print("{:<{}} {}\n", pointer.substr(1), width, apps::JsonText(value));
  }
}

}  // namespace highwall::bench
