#pragma once
/// Parameter files of ROS, read into what a parameter server or a node would have got from them, every leaf
/// with its place.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/ros_files/parameter_substitution.hpp"

namespace polyarm::ros_files {

/// Where parameters come from: a YAML file, or text that stands inside another file.
struct ParameterSource {
  std::filesystem::path file;       ///< read unless `text` is given; names the place in messages either way
  std::string ns;                   ///< the keys of a ROS 1 source stand under it: "/MyRobot"; may be empty
  std::optional<std::string> text;  ///< YAML, its lines counted from the first line of `file`
  bool literal = false;             ///< `text` is no YAML but the one value of the parameter `ns`
  Location where;                   ///< of the value of a literal
  const ParameterSubstitution* substitution = nullptr;  ///< of $(…) in a file of ROS 2; null: they stay
};

/// A map called joint_limits somewhere in a source, to be read by another reader.
struct JointLimitsSource {
  std::filesystem::path file;
  std::optional<std::string> text;  ///< as in ParameterSource
  std::vector<std::string> keys;    ///< the way to the map: {"MyRobot", "joint_limits"}; empty: all of it
  std::string ns;                   ///< where it stands among the names: "/MyRobot"
  Location where;                   ///< of its key
};

/// The parameters of the nodes that a key of a ROS 2 file means.
struct NodeParameters {
  std::vector<std::string> path;  ///< its names and wildcards, never empty: {"**", "controller_manager"}
  controllers::Parameters parameters;
  Location where;
};

/// The parameter server of ROS 1: names in names, values at the leaves.
struct ParameterTree {
  std::map<std::string, ParameterTree, std::less<>> children;
  std::optional<controllers::Parameters::Entry> value;
  Location where;  ///< of the key that was written first

  const ParameterTree* find(std::string_view child) const;
  /// The leaves below as "a.b.c"; `skip` names a child that is left out.
  controllers::Parameters flat(std::string_view skip = {}) const;
};

struct ParameterSet {
  std::vector<NodeParameters> nodes;  ///< ROS 2, in the order of the files
  ParameterTree tree;                 ///< ROS 1, later values over earlier ones
  std::vector<JointLimitsSource> joint_limits;
};

/// Adds a source to `set`. Which form it has is seen from the file: with `ros__parameters` it is of ROS 2.
/// What is wrong in it becomes a problem with its place; throws Error for what cannot be read at all: no such
/// file, no YAML, nesting or aliases without end.
void read_parameters(const ParameterSource& source, ParameterSet& set, Problems& problems);

/// The names of "/a//b/" one by one: {"a", "b"}.
std::vector<std::string> split_name(std::string_view name);
/// "/a/b", and "/" for none.
std::string join_name(const std::vector<std::string>& path);
/// Does a path with `*` (one name) and `**` (any number of names) mean the node called `name`?
bool means_node(const std::vector<std::string>& path, const std::vector<std::string>& name);

}  // namespace polyarm::ros_files
