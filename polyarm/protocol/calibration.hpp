#pragma once
/// Requests that calibrate the geometry of an arm and the payload of a hand from samples of a robot at rest.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/points.hpp"

namespace polyarm::protocol {

struct CalibrateSample {
  static constexpr Facts kFacts{
      .name = "calibrate.sample",
      .role = Role::watch,
      .text =
          "Returns one sample of a robot at rest, for calibrate.joints and calibrate.payload. `marker` names "
          "a "
          "pose of the cell's data, which a measuring device writes; `age`: seconds since it last changed. "
          "With `forces` it measures half a second, and returns the mean of the force sensor at the wrist, "
          "or "
          "of the joint torques if there is none; `noise` is the standard deviation of one reading."};
  std::optional<std::string> robot, marker;
  bool forces = false;
  struct Answer {
    static constexpr const char* kOf = "CalibrateSample";
    std::map<std::string, double> joints;  ///< rad or m
    PoseFacts flange;
    std::optional<PoseFacts> measured;
    std::optional<double> age;
    std::optional<Vec3> force, torque;                     ///< N and N m, in the axes of the flange
    std::optional<std::map<std::string, double>> torques;  ///< N m, by joint
    std::optional<double> noise;                           ///< N or N m
    POLYARM_MEMBERS(Answer, joints, flange, measured, age, force, torque, torques, noise)
  };
  POLYARM_MEMBERS(CalibrateSample, robot, marker, forces)
};

/// An error of one joint.
struct JointError {
  std::string joint;
  double offset = 0, sigma = 0;  ///< rad or m; one standard deviation
  bool identifiable = true;      ///< false: the samples do not show it
  POLYARM_MEMBERS(JointError, joint, offset, sigma, identifiable)
};

struct CalibrateJoints {
  static constexpr Facts kFacts{
      .name = "calibrate.joints",
      .role = Role::program,
      .text =
          "Computes the joint offsets of an arm from `samples` {joints, measured}: joint values, and the "
          "pose "
          "of a target on the hand as a measuring device saw it. `positions`: orientations are ignored; "
          "`in_base`: the device measures in the base of the robot; `of_flange`: it measures the flange "
          "itself. "
          "Writes a file of the arm and the key `calibration` of the robot in cell.yaml, which the cell uses "
          "after cell.reset. With `dry` it stores nothing. With `check` it compares the samples with the "
          "geometry that the robot has now, and stores nothing.",
      .moves = true,
      .watch_with = "dry"};
  Any samples;
  std::optional<std::string> robot;
  bool positions = false, in_base = false, of_flange = false, check = false, dry = false;
  struct Answer {
    static constexpr const char* kOf = "CalibrateJoints";
    std::vector<JointError> joints;  ///< empty with `check`
    /// Of each sample, the target as seen against the target as computed: m and rad.
    std::vector<double> position_residuals, rotation_residuals;
    double position_rms = 0, rotation_rms = 0;
    double position_before = 0, rotation_before = 0;  ///< the same of the geometry that the robot has now
    double shift = 0, turn = 0;                       ///< how far the tool moves by it at most: m and rad
    std::optional<double> outlier;                    ///< the sample that the others contradict, from 0
    std::optional<std::string> file;                  ///< missing with `dry` and `check`
    POLYARM_MEMBERS(Answer, joints, position_residuals, rotation_residuals, position_rms, rotation_rms,
                    position_before, rotation_before, shift, turn, outlier, file)
  };
  POLYARM_MEMBERS(CalibrateJoints, samples, robot, positions, in_base, of_flange, check, dry)
};

struct CalibratePayload {
  static constexpr Facts kFacts{
      .name = "calibrate.payload",
      .role = Role::program,
      .text =
          "Computes mass and centre of what the hand carries besides its tool from `samples` of "
          "calibrate.sample: {flange, force, torque} or {joints, torques}. Writes the key `payload` of the "
          "robot in cell.yaml, which the cell uses after cell.reset. With `dry` it stores nothing. With "
          "`check` "
          "it compares the samples with the tool and the payload that the robot has now, and stores nothing.",
      .moves = true,
      .watch_with = "dry"};
  Any samples;
  std::optional<std::string> robot;
  bool check = false, dry = false;
  struct Answer {
    static constexpr const char* kOf = "CalibratePayload";
    double mass = 0, mass_sigma = 0;  ///< kg, without the tool
    Vec3 center;                      ///< m, in the flange
    double center_sigma = 0;
    double tool_mass = 0;           ///< kg, of the tool as the cell has it
    std::string unit;               ///< of the residuals: N or N m
    std::vector<double> residuals;  ///< of each sample
    double rms = 0;
    std::optional<double> outlier;    ///< the sample that the others contradict, from 0
    std::optional<std::string> file;  ///< missing with `dry` and `check`
    POLYARM_MEMBERS(Answer, mass, mass_sigma, center, center_sigma, tool_mass, unit, residuals, rms, outlier,
                    file)
  };
  POLYARM_MEMBERS(CalibratePayload, samples, robot, check, dry)
};

struct CalibrateUndo {
  static constexpr Facts kFacts{.name = "calibrate.undo",
                                .role = Role::program,
                                .text =
                                    "Takes back what calibrate.joints or calibrate.payload wrote into "
                                    "cell.yaml last, unless the file was "
                                    "changed since. The cell uses it after cell.reset.",
                                .moves = true};
  struct Answer {
    static constexpr const char* kOf = "CalibrateUndo";
    std::string key, robot;
    POLYARM_MEMBERS(Answer, key, robot)
  };
  POLYARM_MEMBERS(CalibrateUndo)
};

}  // namespace polyarm::protocol
