#pragma once
/// What an unfinished calibration has reached, in a file beside the calibration: a later run continues from
/// it.
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "drivers/servo_bus/registers.hpp"

namespace polyarm::servo_bus {

struct Progress {
  enum class Stage { moving, writing };
  struct Joint {
    int min = 0, max = 0;       ///< steps; while moving they may lie outside of one turn
    std::optional<int> zero;    ///< steps; from `writing` on
    std::optional<int> homing;  ///< value of the register; from `writing` on, if it changes
  };
  Stage stage = Stage::moving;
  std::map<std::string, Joint> joints;
};

/// The file for this calibration.
std::filesystem::path progress_file(const std::filesystem::path& calibration);
/// Empty if there is none. Throws Error if it is of other servos or damaged.
std::optional<Progress> read_progress(const std::filesystem::path& calibration, const Family& family);
void write_progress(const std::filesystem::path& calibration, const Family& family, const Progress& progress);
void remove_progress(const std::filesystem::path& calibration);

}  // namespace polyarm::servo_bus
