#include "commands/eval_output.h"

#include <algorithm>

#include <fmt/format.h>

namespace highwall::apps {
namespace {

std::string Quoted(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string quoted = "\"";
  for (const char c : field) {
    if (c == '"') quoted += c;
    quoted += c;
  }
  return quoted + '"';
}

double Rmse(const NamedError& named) {
  return named.error.statistics.rmse;
}

}  // namespace

nlohmann::ordered_json ErrorJson(const TrajectoryError& error) {
  const ErrorStatistics& s = error.statistics;
  nlohmann::ordered_json json = {{"stats",
                                  {{"max", s.max},
                                   {"mean", s.mean},
                                   {"median", s.median},
                                   {"min", s.min},
                                   {"rmse", s.rmse},
                                   {"sse", s.sse},
                                   {"std", s.std}}},
                                 {"associated", error.estimate.size()},
                                 {"time_covered", error.time_covered},
                                 {"scale", error.scale}};
  if (error.open_rotation != OpenRotation::kNone) {
    json["undetermined"] = OpenRotationText(error.open_rotation);
  }
  return json;
}

std::string OpenRotationText(OpenRotation open) {
  switch (open) {
    case OpenRotation::kNone:
      break;
    case OpenRotation::kAboutLine:
      return "all matched positions lie on a straight line: the rotation about it is not "
             "determined by them and taken from the attitudes";
    case OpenRotation::kAll:
      return "all matched positions lie in one point: the rotation is not determined by them and "
             "taken from the attitudes";
  }
  return "";
}

std::string ErrorsCsv(const std::vector<NamedError>& errors) {
  std::string csv = "estimate,rmse,mean,median,std,min,max,sse,associated,time_covered,scale\n";
  for (const auto& [name, error] : errors) {
    const ErrorStatistics& s = error.statistics;
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", Quoted(name), s.rmse, s.mean, s.median,
                       s.std, s.min, s.max, s.sse, error.estimate.size(), error.time_covered,
                       error.scale);
  }
  return csv;
}

std::string ErrorsTable(const std::vector<NamedError>& errors) {
  std::size_t width = 8;
  for (const NamedError& named : errors) width = std::max(width, named.name.size());
  const double least = Rmse(*std::ranges::min_element(errors, {}, Rmse));
  std::string table = fmt::format(
      "  {:<{}}  {:>11} {:>11} {:>11} {:>11} {:>11} {:>11} {:>8} {:>9} {:>9}\n", "estimate", width,
      "rmse", "mean", "median", "std", "min", "max", "matched", "% of time", "scale");
  for (const auto& [name, error] : errors) {
    const ErrorStatistics& s = error.statistics;
    table += fmt::format(
        "{} {:<{}}  {:11.6f} {:11.6f} {:11.6f} {:11.6f} {:11.6f} {:11.6f} {:>8} {:>7.1f} % "
        "{:9.6f}\n",
        s.rmse == least ? '*' : ' ', name, width, s.rmse, s.mean, s.median, s.std, s.min, s.max,
        error.estimate.size(), 100.0 * error.time_covered, error.scale);
  }
  return table;
}

}  // namespace highwall::apps
