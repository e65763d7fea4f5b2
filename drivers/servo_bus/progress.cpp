#include "drivers/servo_bus/progress.hpp"

#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::servo_bus {

namespace fs = std::filesystem;

namespace {
constexpr const char* kStages[] = {"moving", "writing"};
constexpr double kMostSteps = 1e6;

int steps(const Yaml& value) {
  const double number = value.number();
  if (!(std::abs(number) <= kMostSteps) || number != std::floor(number))
    throw Error(Problem{"bad-value", value.where(), "this is no number of steps",
                        "remove this file and calibrate from the beginning"});
  return static_cast<int>(number);
}
}  // namespace

fs::path progress_file(const fs::path& calibration) {
  return calibration.string() + ".unfinished";
}

std::optional<Progress> read_progress(const fs::path& calibration, const Family& family) {
  const fs::path path = progress_file(calibration);
  std::error_code ignored;
  if (calibration.empty() || !fs::exists(path, ignored)) return std::nullopt;
  const Yaml yaml = Yaml::load(path.string());
  const std::string stage = yaml["stage"].text("");
  if (yaml["polyarm"].text("") != "servo_progress/1" || yaml["family"].text("") != family.name ||
      (stage != kStages[0] && stage != kStages[1]))
    throw Error(Problem{"wrong-kind", yaml.where(),
                        std::string("this is no unfinished calibration of ") + family.name + " servos",
                        "remove it and calibrate from the beginning"});
  Progress out;
  out.stage = stage == kStages[1] ? Progress::Stage::writing : Progress::Stage::moving;
  for (const std::string& name : yaml["joints"].keys()) {
    const Yaml joint = yaml["joints"][name];
    Progress::Joint& to = out.joints[name];
    to.min = steps(joint.required("min"));
    to.max = steps(joint.required("max"));
    if (out.stage == Progress::Stage::writing) to.zero = steps(joint.required("zero"));
    if (joint.has("homing")) to.homing = steps(joint["homing"]);
  }
  return out;
}

void write_progress(const fs::path& calibration, const Family& family, const Progress& progress) {
  std::string text =
      std::string("polyarm: servo_progress/1\nfamily: ") + family.name +
      "\n# An unfinished calibration: setup continues from here. Remove it to begin anew.\nstage: " +
      kStages[static_cast<int>(progress.stage)] + "\njoints:\n";
  for (const auto& [name, joint] : progress.joints) {
    text += "  " + name + ": {min: " + std::to_string(joint.min) + ", max: " + std::to_string(joint.max);
    if (joint.zero) text += ", zero: " + std::to_string(*joint.zero);
    if (joint.homing) text += ", homing: " + std::to_string(*joint.homing);
    text += "}\n";
  }
  write_file_atomically(progress_file(calibration), text);
}

void remove_progress(const fs::path& calibration) {
  std::error_code ignored;
  fs::remove(progress_file(calibration), ignored);
}

}  // namespace polyarm::servo_bus
