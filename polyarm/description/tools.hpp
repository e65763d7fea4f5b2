#pragma once
/// Built-in tools and tool files. SI units.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/description/scene.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

/// Thickness of the finger pads of a parallel gripper, m; each lies outside of the gap.
inline constexpr double kFingerThickness = 0.008;

/// The names of the built-in tools, "none" first.
const std::vector<std::string>& built_in_tools();
/// A built-in tool, or the tool file `name` (or `name.yaml`) in `folder` (`polyarm: tool/1`). Throws Error
/// with similar names.
Tool find_tool(const std::string& name, const std::string& folder);
/// Reads a tool file's content.
Tool read_tool(const Yaml& yaml, const std::string& name);
/// A warning about values that a tool file does not state although motion depends on them; empty for built-in
/// tools.
std::optional<Problem> missing_in_tool(const std::string& name, const std::string& folder);

}  // namespace polyarm::description
