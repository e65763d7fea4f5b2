#pragma once
/// Functions shared by message_forms and trajectory_file.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files {

/// Throws Error that lists the keys of `yaml` that are not in `known`.
void check_keys(const Yaml& yaml, const std::vector<std::string>& known);
/// {sec, nanosec}, {secs, nsecs} or a number of seconds.
double seconds_of(const Yaml& yaml, double fallback = 0);
/// The `stamp` of a header; nothing if it is 0, which means now. Throws Error("bad-message").
std::optional<Nanoseconds> stamp_of(const Yaml& header);

}  // namespace polyarm::ros_files
