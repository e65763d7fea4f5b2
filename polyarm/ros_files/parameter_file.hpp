#pragma once
/// Reads ROS parameter files into what a ROS 1 parameter server or a ROS 2 node would get, each value with
/// its location.
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

/// A source of parameters: a YAML file, or text inside another file.
struct ParameterSource {
  std::filesystem::path file;       ///< read if `text` is not given; used in error messages either way
  std::string ns;                   ///< name under which the keys of a ROS 1 source are put: "/MyRobot"; may
                                    ///< be empty
  std::optional<std::string> text;  ///< YAML; its line numbers are those of `file`
  bool literal = false;             ///< `text` is not YAML but the value of the parameter `ns`
  Location where;                   ///< of a literal's value
  const ParameterSubstitution* substitution = nullptr;  ///< for $(…) in a ROS 2 file; null: not replaced
};

/// A map called joint_limits in a source; joint_limits.hpp reads it.
struct JointLimitsSource {
  std::filesystem::path file;
  std::optional<std::string> text;  ///< as in ParameterSource
  std::vector<std::string> keys;    ///< keys that lead to the map: {"MyRobot", "joint_limits"}; empty: the
                                    ///< whole document
  std::string ns;                   ///< namespace of the map: "/MyRobot"
  Location where;                   ///< of its key
};

/// The parameters below one node name of a ROS 2 file; wildcards can name several nodes.
struct NodeParameters {
  std::vector<std::string> path;  ///< names and wildcards, never empty: {"**", "controller_manager"}
  controllers::Parameters parameters;
  Location where;
};

/// The parameters of ROS 1 as a tree: names, with values at the leaves.
struct ParameterTree {
  std::map<std::string, ParameterTree, std::less<>> children;
  std::optional<controllers::Parameters::Entry> value;
  Location where;  ///< of the first key with this name

  const ParameterTree* find(std::string_view child) const;
  /// The leaves below as "a.b.c"; `skip`: a child to leave out.
  controllers::Parameters flat(std::string_view skip = {}) const;
};

struct ParameterSet {
  std::vector<NodeParameters> nodes;  ///< ROS 2, in the order of the files
  ParameterTree tree;                 ///< ROS 1; later values replace earlier ones
  std::vector<JointLimitsSource> joint_limits;
};

/// Adds a source to `set`. A file with `ros__parameters` is of ROS 2, any other of ROS 1. Mistakes become
/// problems with their location. Throws Error if nothing can be read: missing file, invalid YAML, or too deep
/// nesting or too many aliases.
void read_parameters(const ParameterSource& source, ParameterSet& set, Problems& problems);

/// Splits "/a//b/" into {"a", "b"}.
std::vector<std::string> split_name(std::string_view name);
/// "/a/b"; "/" for an empty path.
std::string join_name(const std::vector<std::string>& path);
/// True if a path with `*` (one name) and `**` (any number of names) matches the node `name`.
bool means_node(const std::vector<std::string>& path, const std::vector<std::string>& name);

}  // namespace polyarm::ros_files
