#pragma once
/// What operators, functions and methods of xacro expressions do. Private to the room. Everything throws
/// Error without a place for what cannot be.
#include <string>
#include <vector>

#include "polyarm/description/xacro_value.hpp"

namespace polyarm::description {

/// + - * / // % ** << >> & ^ | and "neg", "~" (of `right` alone), as Python has them.
XacroValue arithmetic(const XacroValue& left, const std::string& sign, const XacroValue& right);
/// < > <= >= == != in, not in, is, is not.
bool compare(const XacroValue& left, const std::string& sign, const XacroValue& right);
/// pi, e, tau, inf, nan.
bool constant(const std::string& name, XacroValue& out);
bool call_builtin(const std::string& name, const XacroList& arguments, XacroValue& out);
bool is_builtin(const std::string& name);
std::vector<std::string> builtin_names();
/// `named` are what is given as name=value; only "format" takes them.
XacroValue call_method(const XacroValue& on, const std::string& name, const XacroList& arguments,
                       const XacroDict& named = {});
/// Gives a key its value, in the place that it had.
void set_key(XacroDict& dict, const XacroValue& key, XacroValue value);
/// What a `for` goes through: items, keys, letters.
XacroList items_of(const XacroValue& value);
XacroValue item_of(const XacroValue& on, const XacroValue& index);
XacroValue slice_of(const XacroValue& on, const XacroValue& begin, const XacroValue& end,
                    const XacroValue& step);
double number_of(const XacroValue& value);
/// 1, and one more for each list or dictionary around what lies deepest.
int depth_of(const XacroValue& value);
/// Letters and items, those of items included.
std::size_t size_of(const XacroValue& value);

}  // namespace polyarm::description
