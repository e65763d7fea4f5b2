#pragma once
/// Points and variables as requests see and change them. Cell thread.
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

/// What requests about points work on.
struct PointOwners {
  const CellSetup& setup;
  const Machine& machine;
  CellData& data;
  const Motions& motions;
  Worker& worker;
};

protocol::PoseFacts pose_facts(const Pose& pose);
/// One value with all that is known of it.
protocol::PointFacts point_facts(const PointOwners& cell, const std::string& name);

/// A point or frame of the cell's data by name. Throws Error("unknown-name").
const data::Value& place_of(const data::DataStore& store, const std::string& name);
/// A point or variable that a data file keeps. Throws Error("unknown-name").
const data::Value& kept_value(const data::DataStore& store, const std::string& name);
/// Throws Error("bad-name").
void check_point_name(const std::string& name);
/// The pose in the world of a frame: the world, a robot's base or a point, which may be in another.
Pose frame_in_world(const CellSetup& setup, const data::DataStore& store, const std::string& frame,
                    int depth = 0);
/// Where the joints are, rad or m, in the robot's order.
std::vector<double> joints_now(const Machine& machine, const CellRobot& robot);
/// {p: [x, y, z], q: [x, y, z, w]}
Pose pose_value(const nlohmann::json& map);
/// [x, y, z] in m; `what` names it in errors.
Vec3 vector_value(const nlohmann::json& list, const char* what);

/// The data set that a change goes into: the one whose file is `file`, else the one that has `name`, else the one with
/// most points.
std::string set_for(const CellData& data, const std::optional<std::string>& file, const std::string& name);
/// The user's own file of a set, whose copy the run works on, and its name.
std::filesystem::path own_file(const CellSetup& setup, const CellData& data, const std::string& set);
std::string file_name(const CellData& data, const std::string& set);

/// Throws Error("too-long") for a name that a request adds and that is longer than names may be.
void require_short_name(const std::string& name);
/// The same, and Error("too-many") where it is new and the cell's data are full.
void require_room_for(const data::DataStore& store, const std::string& name);

/// A set before and after a change of its file.
struct Edited {
  data::DataSet before, after;
  std::string what;  ///< was taken back
};
/// What somebody outside has changed in the user's own file of a set since the run took it from there, as far
/// as the run has it otherwise: by name. `now`: that file's values.
struct Outside {
  std::vector<std::string> changed, added, removed;
  bool any() const { return !changed.empty() || !added.empty() || !removed.empty(); }
};
Outside outside_changes(CellData& data, const std::string& set, const data::DataSet& now);
/// Takes all of that over.
void take_outside_changes(CellData& data, const std::string& set, const data::DataSet& now);
/// Takes over into the running cell what has changed in a set's file.
void adopt(CellData& data, const std::string& set, const Edited& edited);
/// Changes a set's file on the worker, then the running cell; the answer is then made from the cell.
Poll<Done> edit_set(const PointOwners& cell, const std::string& set, const std::string& what,
                    std::function<void(data::ImportFile&)> change);
/// The same for one value, and its group where one is given.
Poll<protocol::ChangedPoint> edit_value(const PointOwners& cell, const std::string& set,
                                        const std::string& what, const std::string& name,
                                        const data::Value& value,
                                        const std::optional<std::string>& group = {});

}  // namespace polyarm::cell
