#pragma once
/// Requests about points and variables of the cell's data, about frames and tools, and path previews.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/programs.hpp"

namespace polyarm::protocol {

/// m; quaternion x y z w; rad.
struct PoseFacts {
  Vec3 p;
  Quaternion q;
  Vec3 rpy;
  POLYARM_MEMBERS(PoseFacts, p, q, rpy)
};

struct TaughtFacts {
  std::string frame, tool, robot;
  POLYARM_MEMBERS(TaughtFacts, frame, tool, robot)
};

enum class ValueKind { boolean, number, text, list, joints, pose, record };
template <>
struct Words<ValueKind> {
  static constexpr const char* kNoun = "kind of values";
  static constexpr const char* kWords[] = {"boolean", "number", "text", "list", "joints", "pose", "record"};
};

/// A point or variable of the cell's data.
struct PointFacts {
  std::string name;
  ValueKind kind = ValueKind::boolean;
  std::string file, text, literal;
  Any value;  ///< a flag, number or text; null for a pose or list
  std::string unit;
  OrNull<PoseFacts> pose, world;
  OrNull<std::map<std::string, double>> joints;  ///< rad or m
  OrNull<TaughtFacts> taught;
  std::string group;
  POLYARM_MEMBERS(PointFacts, name, kind, file, text, literal, value, unit, pose, world, joints, taught,
                  group)
};

/// The same after a change. `undo`: what points.undo would revert.
struct ChangedPoint : PointFacts {
  std::string undo;
  POLYARM_MORE_MEMBERS(ChangedPoint, PointFacts, undo)
};

struct ChangedPoints {
  std::vector<PointFacts> values;
  std::string undo;
  POLYARM_MEMBERS(ChangedPoints, values, undo)
};

struct PointsList {
  static constexpr Facts kFacts{
      .name = "points",
      .role = Role::watch,
      .text =
          "Returns the points and variables of the cell's data, and the file that new ones are written "
          "to."};
  struct Answer {
    static constexpr const char* kOf = "PointsList";
    std::string file;
    std::vector<std::string> files;
    std::vector<PointFacts> values;
    POLYARM_MEMBERS(Answer, file, files, values)
  };
  POLYARM_MEMBERS(PointsList)
};

struct PointsHere {
  static constexpr Facts kFacts{
      .name = "points.here",
      .role = Role::watch,
      .text = "Returns the present pose and joint values of a robot, in the world frame."};
  std::optional<std::string> robot;
  struct Answer {
    static constexpr const char* kOf = "PointsHere";
    std::string robot;
    PoseFacts tcp, flange;
    std::map<std::string, double> joints;
    std::string tool;
    POLYARM_MEMBERS(Answer, robot, tcp, flange, joints, tool)
  };
  POLYARM_MEMBERS(PointsHere, robot)
};

enum class PointKind { pose, joints };
template <>
struct Words<PointKind> {
  static constexpr const char* kNoun = "kind of points";
  static constexpr const char* kWords[] = {"pose", "joints"};
};

struct PointsTeach {
  static constexpr Facts kFacts{
      .name = "points.teach",
      .role = Role::program,
      .text =
          "Stores the present position of the robot as a point, in the user's file and in the running "
          "cell. `kind` is pose or joints; a pose is relative to `frame`. `replace` overwrites an "
          "existing point.",
      .moves = true};
  std::string name;
  std::optional<std::string> robot;
  std::optional<PointKind> kind;
  std::optional<std::string> frame, file, group;
  bool replace = false;
  using Answer = ChangedPoint;
  POLYARM_MEMBERS(PointsTeach, name, robot, kind, frame, file, group, replace)
};

struct PointsSet {
  static constexpr Facts kFacts{
      .name = "points.set",
      .role = Role::program,
      .text =
          "Sets the value of a point or variable: `pose(0.3, 0, 0.1, 180deg, 0, 0)`, `joints(…)`, "
          "`40mm`.",
      .moves = true};
  std::string name, value;
  std::optional<std::string> frame, file;
  using Answer = ChangedPoint;
  POLYARM_MEMBERS(PointsSet, name, value, frame, file)
};

enum class ShiftAlong { frame, own };
template <>
struct Words<ShiftAlong> {
  static constexpr const char* kNoun = "way along";
  static constexpr const char* kWords[] = {"frame", "own"};
};

struct PointsShift {
  static constexpr Facts kFacts{
      .name = "points.shift",
      .role = Role::program,
      .text =
          "Shifts poses by {x, y, z, rx, ry, rz}, `along` the axes of their `frame` (default) or their "
          "`own` axes.",
      .moves = true};
  Names names;
  Map by;
  std::optional<ShiftAlong> along;
  using Answer = ChangedPoints;
  POLYARM_MEMBERS(PointsShift, names, by, along)
};

struct PointsGroup {
  static constexpr Facts kFacts{
      .name = "points.group",
      .role = Role::program,
      .text =
          "Puts points and variables into a group, by a line of their file. An empty text takes them "
          "out of their group. Programs ignore groups.",
      .moves = true};
  Names names;
  std::string group;
  using Answer = ChangedPoints;
  POLYARM_MEMBERS(PointsGroup, names, group)
};

struct PointsRename {
  static constexpr Facts kFacts{
      .name = "points.rename",
      .role = Role::program,
      .text = "Renames a point. `uses` lists the program lines that still have the old name.",
      .moves = true};
  std::string name, to;
  struct Answer : ChangedPoint {
    static constexpr const char* kOf = "PointsRename";
    std::vector<FileLine> uses;
    POLYARM_MORE_MEMBERS(Answer, ChangedPoint, uses)
  };
  POLYARM_MEMBERS(PointsRename, name, to)
};

struct PointsDelete {
  static constexpr Facts kFacts{.name = "points.delete",
                                .role = Role::program,
                                .text = "Deletes a point. `points.undo` restores it.",
                                .moves = true};
  std::string name;
  struct Answer {
    static constexpr const char* kOf = "PointsDelete";
    std::string name, undo;
    POLYARM_MEMBERS(Answer, name, undo)
  };
  POLYARM_MEMBERS(PointsDelete, name)
};

/// Changes that someone else has written into a data file, by name.
struct OutsideFile {
  std::string file;
  std::vector<std::string> changed, added, removed;
  POLYARM_MEMBERS(OutsideFile, file, changed, added, removed)
};
struct OutsideChanges {
  std::vector<OutsideFile> files;
  POLYARM_MEMBERS(OutsideChanges, files)
};

struct PointsOutside {
  static constexpr Facts kFacts{
      .name = "points.outside",
      .role = Role::watch,
      .text = "Lists the names that others changed in the user's data files since the run copied them."};
  using Answer = OutsideChanges;
  POLYARM_MEMBERS(PointsOutside)
};

struct PointsTake {
  static constexpr Facts kFacts{.name = "points.take",
                                .role = Role::program,
                                .text = "Loads these changes into the running cell.",
                                .moves = true};
  using Answer = OutsideChanges;
  POLYARM_MEMBERS(PointsTake)
};

struct PastChange {
  int number = 0;
  std::string when, what;
  POLYARM_MEMBERS(PastChange, number, when, what)
};

struct PointsHistory {
  static constexpr Facts kFacts{.name = "points.history",
                                .role = Role::watch,
                                .text = "Lists the changes of a data file that can be undone, newest first."};
  std::optional<std::string> file;
  using Answer = std::vector<PastChange>;
  POLYARM_MEMBERS(PointsHistory, file)
};

struct PointsUndo {
  static constexpr Facts kFacts{.name = "points.undo",
                                .role = Role::program,
                                .text = "Undoes the last changes of a data file, in the running cell, too.",
                                .moves = true};
  std::optional<std::string> file;
  std::optional<double> steps;
  struct Answer {
    static constexpr const char* kOf = "PointsUndo";
    std::string what;
    POLYARM_MEMBERS(Answer, what)
  };
  POLYARM_MEMBERS(PointsUndo, file, steps)
};

struct PointsFrame {
  static constexpr Facts kFacts{
      .name = "points.frame",
      .role = Role::program,
      .text =
          "Computes a frame from three places: its origin, one on the x axis, one in the xy plane. Each "
          "is [x, y, z]; `from` names three points instead. `angle` is the angle between the two "
          "directions. With `dry` it stores nothing.",
      .moves = true,
      .watch_with = "dry"};
  std::string name;
  std::optional<Any> origin, on_x, in_plane;
  std::optional<Names> from;
  std::optional<std::string> file;
  bool dry = false;
  struct Answer {
    static constexpr const char* kOf = "PointsFrame";
    Merged<ChangedPoint> point;  ///< missing with `dry`
    std::string name;
    PoseFacts pose;
    std::string frame;
    double angle = 0, x_length = 0, y_length = 0;
    POLYARM_MEMBERS(Answer, point, name, pose, frame, angle, x_length, y_length)
  };
  POLYARM_MEMBERS(PointsFrame, name, origin, on_x, in_plane, from, file, dry)
};

struct PointsTool {
  static constexpr Facts kFacts{
      .name = "points.tool",
      .role = Role::program,
      .text =
          "Computes the TCP of a tool from four or more poses {p, q} of tool0 with the tip at one "
          "place; `from` names points that were taught this way. With `dry` it stores nothing.",
      .moves = true,
      .watch_with = "dry"};
  std::string name;
  std::optional<Any> poses;
  std::optional<Names> from;
  std::optional<std::string> robot, file;
  bool dry = false;
  struct Answer {
    static constexpr const char* kOf = "PointsTool";
    Merged<ChangedPoint> point;  ///< missing with `dry`
    std::string name;
    Vec3 tcp, tip;
    std::vector<double> residuals;  ///< m
    double rms = 0, largest = 0;
    double sigma = 0;               ///< m: one standard deviation of the TCP
    std::optional<double> outlier;  ///< the pose that the others contradict, from 0
    PoseFacts next;                 ///< of tool0: the next pose that helps most
    double next_sigma = 0;          ///< m: `sigma` expected with it
    POLYARM_MEMBERS(Answer, point, name, tcp, tip, residuals, rms, largest, sigma, outlier, next, next_sigma)
  };
  POLYARM_MEMBERS(PointsTool, name, poses, from, robot, file, dry)
};

enum class CameraSeat { hand, beside };
template <>
struct Words<CameraSeat> {
  static constexpr const char* kNoun = "place of a camera";
  static constexpr const char* kWords[] = {"hand", "beside"};
};

struct PointsSighting {
  static constexpr Facts kFacts{
      .name = "points.sighting",
      .role = Role::watch,
      .text =
          "Returns a pair for points.camera: the flange of a robot at rest in the world, and a marker as "
          "the camera sees it. `marker` names a pose of the cell's data, which a link, a file or a "
          "program writes. `age`: seconds since it last changed."};
  std::string marker;
  std::optional<std::string> robot;
  struct Answer {
    static constexpr const char* kOf = "PointsSighting";
    PoseFacts flange, marker;
    double age = 0;
    POLYARM_MEMBERS(Answer, flange, marker, age)
  };
  POLYARM_MEMBERS(PointsSighting, marker, robot)
};

struct PointsCamera {
  static constexpr Facts kFacts{
      .name = "points.camera",
      .role = Role::program,
      .text =
          "Computes where a camera is from three or more `sightings` {flange, marker} of "
          "points.sighting. `place`: on the hand (default; the result is in ROBOT/flange), or beside the "
          "robot (in "
          "the world). `robot`: whose hand. With `dry` it stores nothing.",
      .moves = true,
      .watch_with = "dry"};
  std::string name;
  std::optional<Any> sightings;
  std::optional<CameraSeat> place;
  std::optional<std::string> robot, file;
  bool dry = false;
  struct Answer {
    static constexpr const char* kOf = "PointsCamera";
    Merged<ChangedPoint> point;  ///< missing with `dry`
    std::string name, frame;
    PoseFacts camera, marker;  ///< the marker: in the world, or on the flange
    /// Of each sighting, the marker as seen against the marker as computed: m and rad.
    std::vector<double> position_residuals, rotation_residuals;
    double position_rms = 0, rotation_rms = 0;
    double position_sigma = 0, rotation_sigma = 0;  ///< of the camera: one standard deviation
    std::optional<double> outlier;                  ///< the sighting that the others contradict, from 0
    PoseFacts next;                                 ///< of the flange: the next pose that helps most
    double next_sigma = 0;                          ///< `position_sigma` expected with it
    POLYARM_MEMBERS(Answer, point, name, frame, camera, marker, position_residuals, rotation_residuals,
                    position_rms, rotation_rms, position_sigma, rotation_sigma, outlier, next, next_sigma)
  };
  POLYARM_MEMBERS(PointsCamera, name, sightings, place, robot, file, dry)
};

struct PlanPreview {
  static constexpr Facts kFacts{
      .name = "plan.preview",
      .role = Role::watch,
      .text =
          "Plans the motion from the present position `to` a point, joint values or a pose {p, q}. "
          "`kind` is joint or line. Nothing moves."};
  std::optional<std::string> to;
  std::optional<Map> joints, pose;
  std::optional<MoveKind> kind;
  std::optional<std::string> robot;
  std::optional<double> speed;
  struct Answer {
    static constexpr const char* kOf = "PlanPreview";
    bool ok = true;
    std::string reason, robot;
    std::vector<Vec3> path;  ///< of the TCP
    double seconds = 0;
    std::map<std::string, double> joints;  ///< at the end
    PoseFacts pose;
    std::vector<std::string> warnings;
    POLYARM_MEMBERS(Answer, ok, reason, robot, path, seconds, joints, pose, warnings)
  };
  POLYARM_MEMBERS(PlanPreview, to, joints, pose, kind, robot, speed)
};

}  // namespace polyarm::protocol
