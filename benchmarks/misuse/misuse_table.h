#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "misuses.h"
#include "trial.h"

namespace highwall::bench {

// Trials of a recording without a misuse, to which others are compared.
struct RightTrials {
  Trial images;               // without the IMU
  std::optional<Trial> both;  // with it, if there is one
};

// The trials of all misuses and of all right recordings.
class MisuseTable {
 public:
  // Also prints a line on standard error.
  void Add(const Misuse& misuse, const std::string& recording, const Trial& trial,
           const RightTrials& right);
  void AddRight(const std::string& name, const std::string& recording, const Trial& trial);

  // Returns {"misuses": {name: row}, "right": {name: row}, "misuses_total", "right_total"}: a row
  // has the number of its trials, the shares `detected` and `named` (of right recordings:
  // `false_alarms`), medians, and `runs`.
  nlohmann::ordered_json ToJson() const;
  // Prints both tables in Markdown.
  void Print() const;

 private:
  struct Scored {
    std::string recording;
    Trial trial;
    bool detected = false, named = false;
    std::optional<double> over_right, over_images;  // APE over that of a run
  };
  struct Row {
    std::string name;
    bool inertial = false;
    std::vector<Scored> trials;
  };

  static void AddTo(std::vector<Row>* rows, const std::string& name, bool inertial, Scored scored);
  static nlohmann::ordered_json RowJson(const Row& row, bool is_right);
  static void PrintRows(const std::vector<Row>& rows, bool is_right);

  std::vector<Row> misuses_, right_;
};

}  // namespace highwall::bench
