#pragma once
/// What the files of xacro's operators, functions and methods share. Private to them.
#include <cstddef>
#include <cstdint>
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/description/xacro_value.hpp"

namespace polyarm::description {

/// Letters or items that a value may have.
inline constexpr std::size_t kLongest = 1'000'000;

[[noreturn]] inline void refuse(const std::string& what) {
  throw Error("bad-expression", what);
}

bool whole(const XacroValue& value);
/// Of a number without its fraction.
std::int64_t int_of(const XacroValue& value);
/// Counted from the end if it is negative; not checked otherwise.
std::int64_t index_in(const XacroValue& index, std::size_t size);
/// nullptr: the dictionary has no such key.
const XacroValue* value_at(const XacroDict& dict, const XacroValue& key);
bool equal(const XacroValue& a, const XacroValue& b);
bool less(const XacroValue& a, const XacroValue& b);
/// The operators of numbers that have a fraction.
XacroValue real_arithmetic(double a, const std::string& sign, double b);
/// What is put together stays of a size that can be held.
void require_short(std::size_t size);
XacroValue tuple_from(XacroList items);
XacroValue list_from(XacroList items);
/// Each item once, in the order in which they came.
XacroValue set_of(const XacroList& items);
/// "%d of %s" % values
XacroValue filled_in(const std::string& pattern, const XacroValue& given);

}  // namespace polyarm::description
