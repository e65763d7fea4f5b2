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
/// Parses the whole of `text` as a value. Lengths are metres and angles radians unless a unit is given.
/// Returns empty, with the reason in `why`, if the text is not a value.
std::optional<Value> parse_literal(std::string_view text, std::string& why);

/// The facts of a taught point, as written after its numbers in a file: `frame = "table", tool = …`; empty if
/// there are none.
std::string taught_text(const Taught& taught);
/// Reads such facts into `taught`; false, with the reason in `why`, if they are invalid.
bool parse_taught(std::string_view text, Taught& taught, std::string& why);

}  // namespace polyarm::data
