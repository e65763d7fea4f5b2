/// Requests that calibrate the joints of an arm and the payload of its hand, from samples of a robot at rest.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "polyarm/base/file.hpp"
#include "polyarm/calibration/arm_errors.hpp"
#include "polyarm/calibration/payload.hpp"
#include "polyarm/description/arm_calibration.hpp"
#include "polyarm/io/cell_edit.hpp"
#include "polyarm/operation/point_edits.hpp"
#include "polyarm/protocol/calibration.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/tasks/force_states.hpp"

namespace polyarm::cell {

namespace {

namespace fs = std::filesystem;
using namespace protocol;
using Json = nlohmann::json;
constexpr std::size_t kMostCalibrationSamples = 500;
constexpr Nanoseconds kWeighing = 500'000'000;

void require_rest(const PointOwners& cell, std::size_t i) {
  if (cell.machine.snapshot().standing && cell.motions.idle(i)) return;
  if (cell.motions.idle(i))  // it is jogged, or another robot moves
    throw Error("moving", "something in the cell moves", "wait until all robots are at rest");
  throw Error("moving", "'" + cell.setup.robots[i]->entry.name + "' moves", "wait until it is at rest");
}

/// The states that feel what the hand carries.
struct WeighingStates {
  bool sensor = false;
  std::vector<std::size_t> states;  ///< of the sensor: force, torque; else of the joints, in their order
};

WeighingStates weighing_states(const PointOwners& cell, const CellRobot& robot) {
  const std::string& name = robot.entry.name;
  WeighingStates out;
  if (const auto found = force_states(cell.machine, name)) {
    for (const HardwareBlock& block : robot.blocks)
      for (const description::ComponentInfo& each : block.info->components) {
        const auto frame = each.parameters.find("frame_id");
        if (each.kind != "sensor" || each.name != found->sensor || frame == each.parameters.end()) continue;
        if (robot.model.find_link(frame->second) == robot.model.tool_link()) continue;
        throw Error("bad-points",
                    "the force sensor '" + each.name + "' measures in the link '" + frame->second +
                        "', not at the flange",
                    "give `polyarm calibrate payload` samples whose `flange` is the pose of this link");
      }
    out.sensor = true;
    out.states.assign(found->states.begin(), found->states.end());
    return out;
  }
  for (const controllers::JointFacts& joint : robot.joints) {
    const auto state = cell.machine.table().find_state(joint.name + "/effort");
    if (!state)
      throw Error("no-force-reading",
                  "'" + name + "' has no force sensor, and its hardware gives no joint torques",
                  "write `force_sensor: true` at the robot in cell.yaml, for physics, or use hardware that "
                  "measures one of both");
    out.states.push_back(*state);
  }
  return out;
}

/// Sums of readings.
struct Weighed {
  std::vector<double> sum, squares;
  double count = 0;

  void add(const std::vector<double>& now, const std::string& robot) {
    sum.resize(now.size());
    squares.resize(now.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (!std::isfinite(now[i]))
        throw Error("no-force-reading", "the hardware of '" + robot + "' gives no numbers for forces",
                    "look at it");
      sum[i] += now[i];
      squares[i] += now[i] * now[i];
    }
    ++count;
  }
  std::vector<double> mean() const {
    std::vector<double> out = sum;
    for (double& each : out) each /= count;
    return out;
  }
  /// The largest standard deviation of the first `n`.
  double noise(std::size_t n) const {
    double most = 0;
    for (std::size_t i = 0; i < n; ++i)
      most = std::max(most, squares[i] / count - sum[i] * sum[i] / (count * count));
    return std::sqrt(most);
  }
};

void add_forces(CalibrateSample::Answer& to, const WeighingStates& from, const Weighed& weighed,
                const CellRobot& robot) {
  const std::vector<double> mean = weighed.mean();
  if (std::all_of(mean.begin(), mean.end(), [](double each) { return each == 0; }))
    throw Error("no-force-reading",
                "all forces of '" + robot.entry.name + "' are exactly zero: nothing measures them",
                "calibrate in physics or with the real robot");
  to.noise = weighed.noise(from.sensor ? 3 : mean.size());
  if (from.sensor) {
    to.force = Vec3{mean[0], mean[1], mean[2]};
    to.torque = Vec3{mean[3], mean[4], mean[5]};
    return;
  }
  const std::vector<std::string> names = robot.model.joint_names();
  to.torques.emplace();
  for (std::size_t i = 0; i < mean.size(); ++i) (*to.torques)[names[i]] = mean[i];
}

CalibrateSample::Answer standing_sample(const PointOwners& cell, std::size_t i,
                                        const std::optional<std::string>& marker) {
  const CellRobot& robot = *cell.setup.robots[i];
  CalibrateSample::Answer out;
  const std::vector<std::string> names = robot.model.joint_names();
  const std::vector<double> now = joints_now(cell.machine, robot);
  for (std::size_t k = 0; k < names.size(); ++k) out.joints[names[k]] = now[k];
  out.flange = pose_facts(cell.motions.tcp(i) * inverse(robot.tool.tcp));
  if (!marker) return out;
  const data::Value& value = place_of(cell.data.store, *marker);
  if (!value.as_point())
    throw Error("bad-points", "'" + *marker + "' is a joint state", "name the pose that the device writes");
  out.measured = pose_facts(value.as_point()->pose);
  const auto facts = cell.data.store.facts(*marker);
  // A value that has not changed since the cell began is as old as the cell.
  out.age = seconds(cell.machine.now() - (facts ? std::max<Nanoseconds>(0, facts->changed_at) : 0));
  return out;
}

Poll<CalibrateSample::Answer> calibrate_sample(const PointOwners& cell, const CalibrateSample& request) {
  const std::size_t i = robot_named(cell.setup, request.robot);
  require_rest(cell, i);
  CalibrateSample::Answer answer = standing_sample(cell, i, request.marker);
  if (!request.forces) return at_once(answer);
  return [cell, i, answer, states = weighing_states(cell, *cell.setup.robots[i]), weighed = Weighed{},
          begin = cell.machine.now(), last = Nanoseconds{-1}]() mutable -> Progress<CalibrateSample::Answer> {
    require_rest(cell, i);
    const Nanoseconds now = cell.machine.now();
    const CellRobot& robot = *cell.setup.robots[i];
    if (now != last) {
      std::vector<double> readings;
      for (const std::size_t each : states.states) readings.push_back(cell.machine.snapshot().states[each]);
      weighed.add(readings, robot.entry.name);
      last = now;
    }
    if (now - begin < kWeighing) return {};
    add_forces(answer, states, weighed, robot);
    return Progress<CalibrateSample::Answer>::done(answer);
  };
}

/// The samples of a request, each an object.
const Json& sample_list(const Any& given) {
  const Json& list = given.json();
  if (!list.is_array() || list.size() > kMostCalibrationSamples)
    throw Error("bad-argument",
                fmt::format("'samples' is not a list of at most {} samples", kMostCalibrationSamples),
                "take them with calibrate.sample");
  for (const Json& each : list)
    if (!each.is_object()) throw Error("bad-argument", each.dump() + " is not a sample");
  return list;
}

/// The numbers of a map from joints, in the order of the robot.
std::vector<double> by_joint(const Json& sample, const char* key, const description::RobotModel& model) {
  const Json map = sample.value(key, Json());
  std::vector<double> out;
  for (const std::string& name : model.joint_names()) {
    const Json value = map.is_object() ? map.value(name, Json()) : Json();
    if (!value.is_number())
      throw Error("bad-argument", fmt::format("'{}' of a sample has no number for the joint '{}'", key, name),
                  "one number for each joint");
    out.push_back(value.get<double>());
  }
  return out;
}

std::vector<calibration::ArmSample> arm_samples(const Any& given, const description::RobotModel& model) {
  std::vector<calibration::ArmSample> out;
  for (const Json& each : sample_list(given))
    out.push_back({by_joint(each, "joints", model), pose_value(each.value("measured", Json()))});
  return out;
}

std::optional<double> index_of(const std::optional<calibration::Outlier>& outlier) {
  if (!outlier) return std::nullopt;
  return static_cast<double>(outlier->sample);
}

void add_residuals(CalibrateJoints::Answer& to, const calibration::Residuals& residuals) {
  for (const calibration::Residual& each : residuals.each) {
    to.position_residuals.push_back(each.position);
    to.rotation_residuals.push_back(each.rotation);
  }
  to.position_rms = residuals.rms.position;
  to.rotation_rms = residuals.rms.rotation;
  to.outlier = index_of(residuals.outlier);
}

/// What a job of calibrate.joints needs; nothing of it changes meanwhile.
struct JointsJob {
  description::RobotModel model;
  std::string robot;
  fs::path cell_file;
  CalibrateJoints request;
};

struct FoundJoints {
  CalibrateJoints::Answer answer;
  description::ArmCalibration arm;
};

FoundJoints found_joints(const JointsJob& job) {
  const CalibrateJoints& request = job.request;
  const int tip = job.model.tool_link();
  const std::vector<calibration::ArmSample> samples = arm_samples(request.samples, job.model);
  const calibration::ArmOptions options{.axes = false,
                                        .positions_only = request.positions,
                                        .base_known = request.in_base,
                                        .target_known = request.of_flange};
  FoundJoints out;
  if (request.check) {
    add_residuals(out.answer, calibration::arm_residuals(job.model, tip, samples, options));
    out.answer.position_before = out.answer.position_rms;
    out.answer.rotation_before = out.answer.rotation_rms;
    return out;
  }
  const calibration::ArmErrors found = calibration::arm_errors(job.model, tip, samples, options);
  add_residuals(out.answer, found.after);
  out.answer.position_before = found.before.rms.position;
  out.answer.rotation_before = found.before.rms.rotation;
  for (const calibration::ArmNumber& each : found.numbers)
    out.answer.joints.push_back(
        {each.name.substr(0, each.name.rfind(' ')), each.value, each.sigma, each.identifiable});
  out.arm = {job.model.name, fmt::format("{} measured poses", samples.size()), found.origins};
  description::RobotModel corrected = job.model;
  description::apply(out.arm, corrected);  // refuses the origins of another robot
  const calibration::Residual moved = calibration::difference_of(job.model, corrected, tip);
  out.answer.shift = moved.position;
  out.answer.turn = moved.rotation;
  return out;
}

void require_agreement(const std::optional<double>& outlier) {
  if (outlier)
    throw Error("bad-points",
                fmt::format("sample {} contradicts the others; nothing was changed", *outlier + 1),
                "remove it or measure it again");
}

/// The cell file whose robot a calibration changes. Throws Error if the cell has none.
fs::path cell_file_to_change(const CellSetup& setup) {
  const fs::path& file = setup.file.path;
  if (file.extension() == ".yaml" || file.extension() == ".yml") return file;
  throw Error("no-cell-file", "this cell has no cell.yaml that could keep the result",
              "save the cell as a project first");
}

/// A file beside the cell that is not there yet, so that the geometry in use stays for calibrate.undo.
fs::path unused_file(const fs::path& folder, const std::string& robot) {
  std::error_code error;
  for (int k = 1; k < 1000; ++k) {
    fs::path file = folder / (robot + "_calibration" + (k > 1 ? "_" + std::to_string(k) : "") + ".yaml");
    if (!fs::exists(fs::symlink_status(file, error))) return file;
  }
  throw Error("too-many", "the cell has 999 files of calibrations of '" + robot + "'", "delete old ones");
}

std::string stored_joints(const JointsJob& job, const description::ArmCalibration& arm) {
  const fs::path file = unused_file(job.cell_file.parent_path(), job.robot);
  write_file_atomically(file, description::arm_calibration_text(arm));
  try {
    set_robot_key(job.cell_file, job.robot, "calibration", file.filename().string());
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove(file, ignored);
    throw;
  }
  return file.filename().string();
}

Poll<CalibrateJoints::Answer> calibrate_joints(const PointOwners& cell, const CalibrateJoints& request) {
  const CellRobot& robot = *cell.setup.robots[robot_named(cell.setup, request.robot)];
  const bool stores = !request.dry && !request.check;
  const JointsJob job{robot.model, robot.entry.name, stores ? cell_file_to_change(cell.setup) : fs::path(),
                      request};
  return later(cell.worker, [job, stores] {
    FoundJoints found = found_joints(job);
    if (stores) {
      require_agreement(found.answer.outlier);
      found.answer.file = stored_joints(job, found.arm);
    }
    return found.answer;
  });
}

struct PayloadJob {
  description::RobotModel model;
  calibration::KnownLoad tool, load;  ///< the load: tool and payload as the cell has them
  std::string tool_name, robot;
  bool tilted = false;  ///< gravity is not along -z of the robot's base
  std::optional<double> rated;
  fs::path cell_file;
  CalibratePayload request;
};

/// The samples of a payload: of the sensor, or of the joints.
struct PayloadSamples {
  std::vector<calibration::WrenchSample> wrenches;
  std::vector<calibration::TorqueSample> torques;
};

PayloadSamples payload_samples(const PayloadJob& job) {
  PayloadSamples out;
  for (const Json& each : sample_list(job.request.samples)) {
    if (each.contains("force")) {
      calibration::WrenchSample one;
      one.rotation = pose_value(each.value("flange", Json())).rotation;
      one.force = vector_value(each["force"], "force");
      one.torque = vector_value(each.value("torque", Json()), "torque");
      out.wrenches.push_back(one);
    } else {
      const std::vector<double> rest(job.model.actuated.size());
      out.torques.push_back(
          {by_joint(each, "joints", job.model), rest, rest, by_joint(each, "torques", job.model)});
    }
  }
  if (out.wrenches.empty() && out.torques.empty())
    throw Error("bad-points", "there are no samples", "take them with calibrate.sample");
  if (!out.torques.empty() && job.tilted)
    throw Error("bad-points",
                "'" + job.robot + "' does not stand upright, so its joint torques are not understood",
                "use a force sensor");
  if (!out.wrenches.empty() && !out.torques.empty())
    throw Error("bad-points", "some samples are of the force sensor and some of the joints",
                "take all of them with the same hardware");
  return out;
}

double rms_of(const std::vector<double>& values) {
  double square = 0;
  for (const double each : values) square += each * each;
  return std::sqrt(square / std::max<double>(1, static_cast<double>(values.size())));
}

CalibratePayload::Answer found_payload(const PayloadJob& job) {
  const PayloadSamples samples = payload_samples(job);
  const bool of_joints = samples.wrenches.empty();
  const int tip = job.model.tool_link();
  CalibratePayload::Answer out{.tool_mass = job.tool.mass, .unit = of_joints ? "N m" : "N"};
  if (job.request.check) {
    out.mass = job.load.mass - job.tool.mass;
    out.residuals = of_joints ? calibration::load_residuals(job.model, tip, samples.torques, job.load)
                              : calibration::load_residuals(samples.wrenches, job.load);
    out.rms = rms_of(out.residuals);
    return out;
  }
  const calibration::Payload total = of_joints
                                         ? calibration::payload_from_torques(job.model, tip, samples.torques)
                                         : calibration::payload_from_wrenches(samples.wrenches);
  const calibration::Payload found =
      calibration::without_part(total, job.tool, "the tool '" + job.tool_name + "'");
  out.mass = found.mass;
  out.mass_sigma = found.mass_sigma;
  out.center = found.center;
  out.center_sigma = found.center_sigma;
  out.residuals = found.residuals;
  out.rms = found.rms;
  out.outlier = index_of(found.outlier);
  return out;
}

void store_payload(const PayloadJob& job, const CalibratePayload::Answer& found) {
  require_agreement(found.outlier);
  if (job.rated && found.mass > *job.rated)
    throw Error("payload",
                fmt::format("a payload of {:.3g} kg is more than the {:g} kg that {} may carry; nothing was "
                            "changed",
                            found.mass, *job.rated, job.model.name),
                "carry less, or choose a robot that carries it");
  set_robot_key(job.cell_file, job.robot, "payload",
                fmt::format("{{mass: {:.3f}kg, center: [{:.4f}, {:.4f}, {:.4f}]}}", found.mass,
                            found.center.x, found.center.y, found.center.z));
}

Poll<CalibratePayload::Answer> calibrate_payload(const PointOwners& cell, const CalibratePayload& request) {
  const CellRobot& robot = *cell.setup.robots[robot_named(cell.setup, request.robot)];
  const bool stores = !request.dry && !request.check;
  const moves::Payload load = load_of(robot);
  const PayloadJob job{robot.model,
                       {robot.tool.mass, robot.tool.center},
                       {load.mass, load.center},
                       robot.entry.tool,
                       robot.entry.name,
                       (robot.entry.base.rotation * Vec3{0, 0, 1}).z < 1 - 1e-6,
                       robot.model.provenance.payload_kg,
                       stores ? cell_file_to_change(cell.setup) : fs::path(),
                       request};
  return later(cell.worker, [job, stores] {
    CalibratePayload::Answer found = found_payload(job);
    if (stores) {
      store_payload(job, found);
      found.file = job.cell_file.filename().string();
    }
    return found;
  });
}

Poll<CalibrateUndo::Answer> calibrate_undo(const PointOwners& cell, const CalibrateUndo&) {
  return later(cell.worker, [file = cell_file_to_change(cell.setup)] {
    const std::string what = undo_robot_key(file);  // "payload of arm"
    const auto of = what.find(" of ");
    return CalibrateUndo::Answer{what.substr(0, of), what.substr(of + 4)};
  });
}

}  // namespace

std::vector<Handler> calibration_handlers() {
  return handlers<calibrate_sample, calibrate_joints, calibrate_payload, calibrate_undo>();
}

}  // namespace polyarm::cell
