#pragma once
/// Evaluates Python's built-in functions and text methods. Private to the room.
#include <optional>
#include <string>

#include "polyarm/launch/python_value.hpp"

namespace polyarm::ros_files::python {

/// "…%s…" % VALUE or % TUPLE; also %d, %i, %f and %%.
Value filled_percent(const std::string& text, const Value& with);

/// End of the braces that open at `from` in the text of f"…": position of '}' or ':', or the end of the text.
std::size_t end_of_insertion(const std::string& text, std::size_t from);

/// range, enumerate, zip, list, tuple, sorted, reversed; nothing for other functions.
std::optional<Value> function_of_python(const std::string& name, const Arguments& arguments);

/// lower, upper, replace, format, join, split, startswith, endswith, joinpath, keys, values; nothing for
/// other methods.
std::optional<Value> method_of_text(const Value& value, const std::string& name, const Arguments& arguments);

}  // namespace polyarm::ros_files::python
