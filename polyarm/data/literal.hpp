#pragma once
/// A value as one line of text that reads back to the same value, whatever its type.
///
///   true   12.5   40mm   "a text\n"   [1, 2, "x"]   {name = 1, other = [2]}
///   pose(x, y, z, rx, ry, rz)   quat(x, y, z, qx, qy, qz, qw)   joints(elbow_joint = 0.5, …)
///   pose(…, frame = "table", tool = "gripper", robot = "maker/model", joints = joints(…))
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/data/value.hpp"

namespace polyarm::data {

std::string literal(const Value& value);
/// The value that fills all of `text`. Lengths are metres and angles radians where no unit is said. Nothing,
/// and `why`, where it is none.
std::optional<Value> parse_literal(std::string_view text, std::string& why);

/// What a point remembers, as it stands behind its numbers in a file: `frame = "table", tool = …`; empty
/// where there is nothing.
std::string taught_text(const Taught& taught);
/// Reads that into `taught`; false, and `why`, where it is none.
bool parse_taught(std::string_view text, Taught& taught, std::string& why);

}  // namespace polyarm::data
