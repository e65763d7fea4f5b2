#pragma once
/// Functions shared by the files of xacro's operators, functions and methods. Private to them.
#include <cstddef>
#include <cstdint>
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::description {

/// The largest number of letters or items of a value.
inline constexpr std::size_t kLongest = 1'000'000;

[[noreturn]] inline void refuse(const std::string& what) {
  throw Error("bad-expression", what);
}

bool whole(const XacroValue& value);
/// The number without its fraction.
std::int64_t int_of(const XacroValue& value);
/// A negative index counts from the end; no range check.
std::int64_t index_in(const XacroValue& index, std::size_t size);
/// nullptr if the dictionary does not have the key.
const XacroValue* value_at(const XacroDict& dict, const XacroValue& key);
bool equal(const XacroValue& a, const XacroValue& b);
bool less(const XacroValue& a, const XacroValue& b);
/// The operators for floating-point numbers.
XacroValue real_arithmetic(double a, const std::string& sign, double b);
/// Throws Error if a combined value would be too large.
void require_short(std::size_t size);
XacroValue tuple_from(XacroList items);
XacroValue list_from(XacroList items);
/// Each item once, in order of first occurrence.
XacroValue set_of(const XacroList& items);
/// "%d of %s" % values
XacroValue filled_in(const std::string& pattern, const XacroValue& given);

}  // namespace polyarm::description
