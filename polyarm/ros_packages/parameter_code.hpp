#pragma once
/// Reads the parameter files of generate_parameter_library and writes their header: a struct Params, and the
/// class ParamListener that keeps it equal to the parameters of a node.
#include <filesystem>
#include <string>

#include "polyarm/ros_packages/bounds.hpp"

namespace polyarm::ros_packages {

/// The header for `text`, the content of the YAML file `name`. `validators`: the header with the package's own
/// validators, as #include names it; empty if there is none. Throws Error("bad-parameters") with the place.
std::string parameter_header(const std::string& text, const std::string& name,
                             const std::string& validators);

}  // namespace polyarm::ros_packages
