#pragma once
/// How requests read and change points and variables. Cell thread.
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/data/set_edit.hpp"
#include "polyarm/io/errand.hpp"
#include "polyarm/machine/cell_data.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/machine/motions.hpp"
#include "polyarm/protocol/points.hpp"

namespace polyarm::cell {

/// The parts of the cell that requests about points need.
struct PointOwners {
  const CellSetup& setup;
  const Machine& machine;
  CellData& data;
  const Motions& motions;
  Worker& worker;
};

protocol::PoseFacts pose_facts(const Pose& pose);
/// One value with all facts about it.
protocol::PointFacts point_facts(const PointOwners& cell, const std::string& name);

/// Finds a point or frame in the cell's data. Throws Error("unknown-name").
const data::Value& place_of(const data::DataStore& store, const std::string& name);
/// Finds a point or variable that is stored in a data file. Throws Error("unknown-name").
const data::Value& kept_value(const data::DataStore& store, const std::string& name);
/// Throws Error("bad-name").
void check_point_name(const std::string& name);
/// T_world_frame of a frame: the world, a frame on a robot or a point, which may itself be in another frame.
/// `own`: the robot whose base is the frame `base`; null: that of a cell with one robot. `motions`: for the
/// flange and TCP of a robot, where they are now; null: they are not known. Throws Error("unknown-frame").
Pose frame_in_world(const CellSetup& setup, const data::DataStore& store, const std::string& frame,
                    const CellRobot* own, const Motions* motions = nullptr);
/// T_world_point of a point, the same way.
Pose point_in_world(const CellSetup& setup, const data::DataStore& store, const data::Point& point,
                    const CellRobot* own, const Motions* motions = nullptr);
/// Present joint positions, rad or m, in the robot's order.
std::vector<double> joints_now(const Machine& machine, const CellRobot& robot);
/// Parses {p: [x, y, z], q: [x, y, z, w]}.
Pose pose_value(const nlohmann::json& map);
/// Parses [x, y, z] in m; `what` names the value in errors.
Vec3 vector_value(const nlohmann::json& list, const char* what);

/// The data set that a change goes to: the one whose file is `file`, otherwise the one that contains `name`,
/// otherwise the one with most points.
std::string set_for(const CellData& data, const std::optional<std::string>& file, const std::string& name);
/// The user's own file of a set (the run works on a copy), and its name.
std::filesystem::path own_file(const CellSetup& setup, const CellData& data, const std::string& set);
std::string file_name(const CellData& data, const std::string& set);

/// Throws Error("too-long") if a name that a request adds is too long.
void require_short_name(const std::string& name);
/// The same; also throws Error("too-many") if the name is new and the cell's data are full.
void require_room_for(const data::DataStore& store, const std::string& name);

/// A set before and after a change of its file.
struct Edited {
  data::DataSet before, after;
  std::string what;  ///< description of the change that was undone
};
/// Names that somebody changed in the user's own file of a set since the run read it, if the run's value
/// differs. `now`: the values of that file.
struct Outside {
  std::vector<std::string> changed, added, removed;
  bool any() const { return !changed.empty() || !added.empty() || !removed.empty(); }
};
Outside outside_changes(CellData& data, const std::string& set, const data::DataSet& now);
/// Copies all of these changes into the running cell.
void take_outside_changes(CellData& data, const std::string& set, const data::DataSet& now);
/// Copies what changed in a set's file into the running cell.
void adopt(CellData& data, const std::string& set, const Edited& edited);
/// Changes a set's file on the worker, then the running cell; after that the answer is made from the cell.
Poll<Done> edit_set(const PointOwners& cell, const std::string& set, const std::string& what,
                    std::function<void(data::ImportFile&)> change);
/// The same for one value, and its group if given.
Poll<protocol::ChangedPoint> edit_value(const PointOwners& cell, const std::string& set,
                                        const std::string& what, const std::string& name,
                                        const data::Value& value,
                                        const std::optional<std::string>& group = {});

}  // namespace polyarm::cell
