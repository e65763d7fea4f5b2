#pragma once
/// Operators, functions and methods of xacro expressions. Private to this room. If an operation is invalid,
/// they throw an Error without a place.
#include <string>
#include <vector>

#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::description {

/// + - * / // % ** << >> & ^ | and "neg", "~" (these two use only `right`), as in Python.
XacroValue arithmetic(const XacroValue& left, const std::string& sign, const XacroValue& right);
/// < > <= >= == != in, not in, is, is not.
bool compare(const XacroValue& left, const std::string& sign, const XacroValue& right);
/// pi, e, tau, inf, nan.
bool constant(const std::string& name, XacroValue& out);
bool call_builtin(const std::string& name, const XacroList& arguments, XacroValue& out);
bool is_builtin(const std::string& name);
std::vector<std::string> builtin_names();
/// `named` are the arguments of the form name=value; only "format" accepts them.
XacroValue call_method(const XacroValue& on, const std::string& name, const XacroList& arguments,
                       const XacroDict& named = {});
/// Sets the value of a key; an existing key keeps its position.
void set_key(XacroDict& dict, const XacroValue& key, XacroValue value);
/// The items that a `for` iterates over: items, keys, letters.
XacroList items_of(const XacroValue& value);
XacroValue item_of(const XacroValue& on, const XacroValue& index);
XacroValue slice_of(const XacroValue& on, const XacroValue& begin, const XacroValue& end,
                    const XacroValue& step);
double number_of(const XacroValue& value);
/// The nesting depth of lists and dictionaries, plus one.
int depth_of(const XacroValue& value);
/// The number of letters and items, including nested ones.
std::size_t size_of(const XacroValue& value);

}  // namespace polyarm::description
