#include "report/report_words.h"

#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "run/loss_advice.h"

namespace highwall::apps {
namespace {

constexpr double kSeenRowTime = 0.003;  // [s] maximum deviation, as in `highwall calibrate`

using Pointer = nlohmann::json::json_pointer;

std::size_t Count(const nlohmann::json& json, const char* pointer) {
  return json.value(Pointer(pointer), std::size_t{0});
}

double Number(const nlohmann::json& json, const char* pointer) {
  return json.value(Pointer(pointer), 0.0);
}

// Groups digits in threes with a narrow space, as on the page.
std::string Grouped(std::size_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, "\u202f");
  return digits;
}

// Returns a text such as "1 loop" or "2 loops".
std::string Counted(std::size_t count, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", Grouped(count), count == 1 ? one : many);
}
std::string Counted(std::size_t count, const std::string& noun) {
  return Counted(count, noun, noun + "s");
}

// Uses millimetres below 10 cm, otherwise metres.
std::string Length(double metres) {
  return metres < 0.1 ? fmt::format("{:.1f} mm", 1e3 * metres) : fmt::format("{:.3f} m", metres);
}

std::string Tracking(const nlohmann::json& run) {
  const std::size_t frames = Count(run, "/frames"), lost = Count(run, "/lost_frames");
  std::string text =
      fmt::format("{} of {} have a pose", Grouped(frames - lost), Counted(frames, "frame"));
  text += fmt::format(", {:.1f} % of the recording.", 100.0 * Number(run, "/coverage"));
  const auto reasons = run.value("loss_reasons", std::map<std::string, std::size_t>());
  if (const std::string advice = LossAdvice(reasons, lost); !advice.empty()) {
    text += " " + advice + ".";
  }
  if (const std::size_t n = Count(run, "/without_depth"); n > 0) {
    text += fmt::format(" {} no depth image in time.",
                        Counted(n, "colour image has", "colour images have"));
  }
  if (const std::size_t n = Count(run, "/skipped_frames"); n > 0) {
    text += fmt::format(" {} could not be read.", Counted(n, "image"));
  }
  if (const std::size_t n = Count(run, "/dropped_frames"); n > 0) {
    text += fmt::format(" {} came too fast and {} dropped.", Counted(n, "image"),
                        n == 1 ? "was" : "were");
  }
  if (const std::size_t n = Count(run, "/relocalizations"); n > 0) {
    text += fmt::format(" Tracking relocalized {}.", Counted(n, "time"));
  }
  if (const std::size_t n = Count(run, "/open_frames"); n > 0) {
    text += fmt::format(" {} left a direction of the pose unobservable.", Counted(n, "frame"));
  }
  return text;
}

std::string Verdict(const nlohmann::json& run) {
  std::string text =
      "Recording and configuration: " + run.value(Pointer("/verdict/trust"), "") + ".";
  for (const nlohmann::json& finding :
       run.value(Pointer("/verdict/findings"), nlohmann::json::array())) {
    const std::string remedy = finding.value("remedy", "");
    text += " " + finding.value("text", "") + (remedy.empty() ? "." : ": " + remedy + ".");
  }
  return text;
}

std::string Error(const nlohmann::json& errors) {
  if (errors.is_null()) {
    return "The accuracy is unknown, because there is no ground truth: judge it by closed loops "
           "and by "
           "double walls in the cloud.";
  }
  return fmt::format(
      "Against the ground truth the absolute error is {} (RMSE, rigid alignment; the largest {}), "
      "and {} over a second ({}; RMSE). Poses cover {:.1f} % of the time of the ground truth.",
      Length(Number(errors, "/ape/rmse")), Length(Number(errors, "/ape/max")),
      Length(Number(errors, "/rpe/rmse")), Counted(Count(errors, "/rpe/frames"), "frame"),
      100.0 * Number(errors, "/time_covered"));
}

std::string Mapping(const nlohmann::json& run) {
  std::string text =
      fmt::format("The map holds {}, {} and {}.", Counted(Count(run, "/keyframes"), "keyframe"),
                  Counted(Count(run, "/landmarks/points"), "point"),
                  Counted(Count(run, "/landmarks/lines"), "line"));
  const std::size_t closed = Count(run, "/loops/closed"), refused = Count(run, "/loops/refused");
  if (closed + refused == 0) {
    text += " No loop was closed.";
  } else {
    text +=
        fmt::format(" {} closed, {} rejected.", Counted(closed, "loop was", "loops were"), refused);
  }
  const std::size_t merges = Count(run, "/loops/merges");
  if (merges > 0) text += fmt::format(" {} joined separate maps.", Counted(merges, "merge"));
  const std::size_t maps = run.value("submaps", nlohmann::json::array()).size();
  if (maps > 1) text += fmt::format(" {} separate maps remain.", maps);
  if (run.contains(Pointer("/map/cloud"))) {
    text += fmt::format(
        " The dense cloud has {}, the octree {} of {:.3g} cm.",
        Counted(Count(run, "/map/cloud/points"), "point"),
        Counted(Count(run, "/map/octree/occupied_leaves"), "occupied leaf", "occupied leaves"),
        100.0 * Number(run, "/map/octree/resolution_m"));
  }
  return text;
}

std::string Inertial(const nlohmann::json& imu) {
  if (!imu.contains("initialized")) {
    return "The IMU was not used: " + imu.value("reason", "it was never initialized") + ".";
  }
  std::string text = fmt::format(
      "The mean weight of the IMU is {:.2f}, its squared innovation {:.2f} per degree of freedom "
      "(1 "
      "if the noise model is right). Its clock is {:+.2f} ms from the camera's.",
      Number(imu, "/mean_weight"), Number(imu, "/innovation_per_dof"),
      1e3 * Number(imu, "/time_offset/value"));
  if (const std::size_t n = Count(imu, "/dead_reckoned_frames"); n > 0) {
    text += fmt::format(" {} by the IMU alone.",
                        Counted(n, "frame has its pose", "frames have their pose"));
  }
  if (const std::size_t n = Count(imu, "/contradicted_intervals"); n > 0) {
    text += fmt::format(" The images contradicted its readings in {}: tracking did not use these.",
                        Counted(n, "interval"));
  }
  if (const std::size_t n = Count(imu, "/saturated_intervals"); n > 0) {
    text += fmt::format(" In {} readings saturate the sensor.", Counted(n, "interval"));
  }
  if (imu.contains("depth_scale")) {
    text += fmt::format(" True depth is {:.4f} ± {:.4f} times the measured depth.",
                        Number(imu, "/depth_scale/value"), Number(imu, "/depth_scale/sigma"));
  }
  return text;
}

std::string Timing(const nlohmann::json& run) {
  const auto value = [&](const char* key, double sign) {
    const std::string at = std::string("/frame_timing_s/value/") + key;
    const std::string sigma = std::string("/frame_timing_s/sigma/") + key;
    const double deviation = Number(run, sigma.c_str());
    return fmt::format("{:.1f} ± {:.1f} ms{}", sign * 1e3 * Number(run, at.c_str()),
                       1e3 * deviation, deviation < kSeenRowTime ? "" : " (hardly observed)");
  };
  const bool early = Number(run, "/frame_timing_s/value/depth_delay") < 0.0;
  return fmt::format(
      "From the first row of an image to the last pass {} in colour and {} in depth; depth is {} "
      "{} than its stamp.",
      value("colour_readout", 1.0), value("depth_readout", 1.0),
      value("depth_delay", early ? -1.0 : 1.0), early ? "earlier" : "later");
}

std::string Speed(const nlohmann::json& run) {
  std::string words = fmt::format(
      "A frame took {:.1f} ms (median; 95 % within {:.1f} ms), the whole run {:.0f} s and {:.0f} "
      "MiB.",
      Number(run, "/milliseconds/frame/median"), Number(run, "/milliseconds/frame/p95"),
      Number(run, "/seconds"), Number(run, "/peak_memory_mib"));
  if (run.contains("processor_ms_per_frame")) {  // not of earlier versions
    words += fmt::format(
        " 99 % of the frames took at most {:.1f} ms, the worst {:.1f} ms; the processors worked "
        "{:.1f} ms for each, without the decoding of its images.",
        Number(run, "/milliseconds/frame/p99"), Number(run, "/milliseconds/frame/worst"),
        Number(run, "/processor_ms_per_frame"));
  }
  return words;
}

}  // namespace

std::vector<std::string> SummaryInWords(const nlohmann::json& run, const nlohmann::json& errors) {
  std::vector<std::string> words;
  if (run.contains("frames")) words.push_back(Tracking(run));
  if (run.contains("verdict")) words.push_back(Verdict(run));
  if (run.contains("runs")) {
    words.push_back(fmt::format("These are {} in one map.", Counted(run["runs"].size(), "run")));
  }
  words.push_back(Error(errors));
  words.push_back(Mapping(run));
  if (run.contains("imu")) words.push_back(Inertial(run["imu"]));
  if (run.contains("frame_timing_s")) words.push_back(Timing(run));
  if (run.contains("milliseconds")) words.push_back(Speed(run));
  if (!run.value("complete", true)) {
    words.push_back(
        "The run is not complete: " +
        fmt::format("{}", fmt::join(run.value("failures", std::vector<std::string>()), "; ")) +
        ".");
  }
  return words;
}

}  // namespace highwall::apps
