/// The functions of xacro expressions, by name.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_functions.hpp"
#include "polyarm/xacro/xacro_parts.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

namespace {

using Function = std::function<XacroValue(const XacroList&)>;

Function real(double (*f)(double)) {
  return [f](const XacroList& a) -> XacroValue {
    if (a.size() != 1) refuse("the function takes one number");
    const double x = number_of(a[0]), out = f(x);
    if (std::isfinite(x) && !std::isfinite(out)) refuse("the function has no value at " + float_text(x));
    return out;
  };
}

Function two(double (*f)(double, double)) {
  return [f](const XacroList& a) -> XacroValue {
    if (a.size() != 2) refuse("the function takes two numbers");
    const double x = number_of(a[0]), y = number_of(a[1]), out = f(x, y);
    if (std::isnan(out) && !std::isnan(x) && !std::isnan(y)) refuse("the function has no value there");
    return out;
  };
}

/// min and max, of the arguments or of a single list.
XacroValue extreme(const XacroList& given, bool largest) {
  const XacroList items = given.size() == 1 ? items_of(given[0]) : given;
  if (items.empty()) refuse("there is nothing to choose from");
  const XacroValue* best = &items.front();
  for (const XacroValue& item : items)
    if (largest ? less(*best, item) : less(item, *best)) best = &item;
  return *best;
}

/// Rounds to nearest, halves to even, using the digits of the number as stored.
XacroValue rounded(const XacroList& a) {
  const double x = number_of(a.at(0));
  if (a.size() == 1) {
    if (!(std::abs(x) < 9e18)) refuse("the number cannot be rounded");
    return whole(a[0]) ? XacroValue(int_of(a[0])) : XacroValue(static_cast<std::int64_t>(std::nearbyint(x)));
  }
  const std::int64_t digits = int_of(a[1]);
  if (digits > 22 || !std::isfinite(x)) return a[0];
  if (digits < 0) {
    const double scale = std::pow(10.0, static_cast<double>(std::min<std::int64_t>(-digits, 309)));
    const double out = std::isinf(scale) ? 0 : std::nearbyint(x / scale) * scale;
    return whole(a[0]) ? XacroValue(int_of(out)) : XacroValue(out);
  }
  return whole(a[0]) ? a[0] : XacroValue(std::stod(fmt::format("{:.{}f}", x, digits)));
}

XacroValue range_of(const XacroList& a) {
  if (a.empty() || a.size() > 3) refuse("range takes one to three numbers");
  const std::int64_t begin = a.size() > 1 ? int_of(a[0]) : 0, end = int_of(a[a.size() > 1 ? 1 : 0]);
  const std::int64_t step = a.size() > 2 ? int_of(a[2]) : 1;
  if (step == 0) refuse("the step of a range is 0");
  auto out = std::make_shared<XacroList>();
  for (std::int64_t k = begin; step > 0 ? k < end : k > end;) {
    if (out->size() >= kLongest) refuse("the range is too long");
    spend(1);
    out->emplace_back(k);
    if (__builtin_add_overflow(k, step, &k)) break;
  }
  return out;
}

XacroValue int_in_base(const std::string& written, std::int64_t base) {
  std::string text = lower(std::string(trim(written)));
  if (base == 16 && text.starts_with("0x")) text.erase(0, 2);
  if (base == 2 && text.starts_with("0b")) text.erase(0, 2);
  std::int64_t out = 0;
  const char* end = text.data() + text.size();
  if (base < 2 || base > 36) refuse("numbers have no base " + std::to_string(base));
  const auto read = std::from_chars(text.data(), end, out, static_cast<int>(base));
  if (read.ec != std::errc() || read.ptr != end) refuse("'" + written + "' is not a whole number");
  return out;
}

XacroValue int_from(const XacroList& a) {
  const XacroValue& value = a.at(0);
  if (a.size() > 1 && value.text()) return int_in_base(*value.text(), int_of(a[1]));
  if (!value.text()) return int_of(value);
  const XacroValue read = literal_of(std::string(trim(*value.text())));
  if (!std::holds_alternative<std::int64_t>(read.data)) refuse(repr_of(value) + " is not a whole number");
  return read;
}

XacroValue float_from(const XacroValue& value) {
  if (!value.text()) return number_of(value);
  const XacroValue read = literal_of(std::string(trim(*value.text())));
  if (!read.is_number() || std::holds_alternative<bool>(read.data))
    refuse(repr_of(value) + " is not a number");
  return number_of(read);
}

XacroValue zipped(const XacroList& a) {
  std::vector<XacroList> columns;
  std::size_t n = kLongest;
  for (const XacroValue& list : a) {
    columns.push_back(items_of(list));
    n = std::min(n, columns.back().size());
  }
  XacroList out;
  for (std::size_t i = 0; i < n && !columns.empty(); ++i) {
    XacroList row;
    for (const XacroList& column : columns) row.push_back(column[i]);
    out.push_back(tuple_from(std::move(row)));
  }
  return list_from(std::move(out));
}

XacroValue dict_of(const XacroList& a) {
  auto out = std::make_shared<XacroDict>();
  if (a.empty()) return out;
  if (a[0].dict()) return std::make_shared<XacroDict>(*a[0].dict());
  for (const XacroValue& pair : items_of(a[0])) {
    const XacroList both = items_of(pair);
    if (both.size() != 2) refuse("a dictionary is made of pairs");
    set_key(*out, both[0], both[1]);
  }
  return out;
}

XacroFunction type_of(const XacroValue& value) {
  static const char* const names[] = {"NoneType", "bool", "int",       "float", "str",
                                      "list",     "dict", "NameSpace", "type"};
  if (value.list() && value.list()->is_tuple) return {"tuple"};
  return {names[value.data.index()]};
}

bool is_instance(const XacroValue& value, const XacroValue& type) {
  if (const XacroList* types = type.list())
    return std::any_of(types->begin(), types->end(),
                       [&](const XacroValue& t) { return is_instance(value, t); });
  const auto* wanted = std::get_if<XacroFunction>(&type.data);
  if (!wanted) refuse(repr_of(type) + " is not a type");
  return wanted->name == type_of(value).name ||
         (wanted->name == "int" && std::holds_alternative<bool>(value.data));
}

/// map() and filter(): the function's value for each item, or the items for which it is true.
XacroValue through(const XacroList& a, bool choose) {
  const auto* function = std::get_if<XacroFunction>(&a.at(0).data);
  if (!function && !(choose && std::holds_alternative<std::monostate>(a[0].data)))
    refuse(repr_of(a[0]) + " is not a function");
  XacroList out;
  for (const XacroValue& item : items_of(a.at(1))) {
    XacroValue value = item;
    if (function && !call_builtin(function->name, {item}, value))
      refuse("there is no function '" + function->name + "'");
    if (!choose || truth_of(value)) out.push_back(choose ? item : value);
  }
  return list_from(std::move(out));
}

XacroValue sorted(const XacroList& a) {
  XacroList items = items_of(a.at(0));
  std::stable_sort(items.begin(), items.end(), less);
  return list_from(std::move(items));
}

std::map<std::string, Function> functions_of_numbers() {
  return {
      {"sin", real(std::sin)},
      {"cos", real(std::cos)},
      {"tan", real(std::tan)},
      {"asin", real(std::asin)},
      {"acos", real(std::acos)},
      {"atan", real(std::atan)},
      {"sinh", real(std::sinh)},
      {"cosh", real(std::cosh)},
      {"tanh", real(std::tanh)},
      {"exp", real(std::exp)},
      {"log10", real(std::log10)},
      {"fabs", real(std::fabs)},
      {"asinh", real(std::asinh)},
      {"acosh", real(std::acosh)},
      {"atanh", real(std::atanh)},
      {"exp2", real(std::exp2)},
      {"expm1", real(std::expm1)},
      {"log1p", real(std::log1p)},
      {"log2", real(std::log2)},
      {"cbrt", real(std::cbrt)},
      {"sqrt",
       [](const XacroList& a) -> XacroValue {
         const double x = number_of(a.at(0));
         if (x < 0) refuse("the square root of a negative number");
         return std::sqrt(x);
       }},
      {"log",
       [](const XacroList& a) -> XacroValue {
         if (!(number_of(a.at(0)) > 0)) refuse("the logarithm of a number that is not above 0");
         return a.size() > 1 ? std::log(number_of(a[0])) / std::log(number_of(a[1]))
                             : std::log(number_of(a[0]));
       }},
      {"atan2", two(std::atan2)},
      {"hypot", two(std::hypot)},
      {"fmod", two(std::fmod)},
      {"copysign", two(std::copysign)},
      {"pow",
       [](const XacroList& a) { return real_arithmetic(number_of(a.at(0)), "**", number_of(a.at(1))); }},
      {"radians",
       [](const XacroList& a) -> XacroValue { return number_of(a.at(0)) * (std::numbers::pi / 180); }},
      {"degrees",
       [](const XacroList& a) -> XacroValue { return number_of(a.at(0)) * (180 / std::numbers::pi); }},
      {"floor", [](const XacroList& a) -> XacroValue { return int_of(std::floor(number_of(a.at(0)))); }},
      {"ceil", [](const XacroList& a) -> XacroValue { return int_of(std::ceil(number_of(a.at(0)))); }},
      {"trunc", [](const XacroList& a) -> XacroValue { return int_of(std::trunc(number_of(a.at(0)))); }},
      {"isnan", [](const XacroList& a) -> XacroValue { return std::isnan(number_of(a.at(0))); }},
      {"isinf", [](const XacroList& a) -> XacroValue { return std::isinf(number_of(a.at(0))); }},
      {"isfinite", [](const XacroList& a) -> XacroValue { return std::isfinite(number_of(a.at(0))); }},
      {"isclose",
       [](const XacroList& a) -> XacroValue {
         const double x = number_of(a.at(0)), y = number_of(a.at(1));
         return x == y || std::abs(x - y) <= 1e-9 * std::max(std::abs(x), std::abs(y));
       }},
      {"abs",
       [](const XacroList& a) {
         return number_of(a.at(0)) < 0 ? arithmetic({}, "neg", a[0])
                : whole(a[0])          ? XacroValue(int_of(a[0]))
                                       : XacroValue(std::abs(number_of(a[0])));
       }},
      {"divmod",
       [](const XacroList& a) {
         return tuple_from({arithmetic(a.at(0), "//", a.at(1)), arithmetic(a[0], "%", a[1])});
       }},
      {"round", rounded},
      {"int", int_from},
  };
}

std::map<std::string, Function> functions_of_types() {
  return {
      {"ord",
       [](const XacroList& a) -> XacroValue {
         if (!a.at(0).text() || a[0].text()->size() != 1) refuse("'ord' takes one letter");
         return std::int64_t{static_cast<unsigned char>((*a[0].text())[0])};
       }},
      {"repr", [](const XacroList& a) -> XacroValue { return repr_of(a.at(0)); }},
      {"dict", dict_of},
      {"dotify", dict_of},
      {"set", [](const XacroList& a) { return set_of(a.empty() ? XacroList{} : items_of(a[0])); }},
      {"frozenset", [](const XacroList& a) { return set_of(a.empty() ? XacroList{} : items_of(a[0])); }},
      {"type", [](const XacroList& a) -> XacroValue { return type_of(a.at(0)); }},
      {"isinstance", [](const XacroList& a) -> XacroValue { return is_instance(a.at(0), a.at(1)); }},
      {"map", [](const XacroList& a) { return through(a, false); }},
      {"filter", [](const XacroList& a) { return through(a, true); }},
      {"float", [](const XacroList& a) { return float_from(a.at(0)); }},
      {"str", [](const XacroList& a) -> XacroValue { return str_of(a.at(0)); }},
      {"bool", [](const XacroList& a) -> XacroValue { return truth_of(a.at(0)); }},
  };
}

std::map<std::string, Function> functions_of_lists() {
  return {
      {"len",
       [](const XacroList& a) -> XacroValue { return static_cast<std::int64_t>(items_of(a.at(0)).size()); }},
      {"min", [](const XacroList& a) { return extreme(a, false); }},
      {"max", [](const XacroList& a) { return extreme(a, true); }},
      {"sum",
       [](const XacroList& a) {
         XacroValue out = std::int64_t{0};
         for (const XacroValue& item : items_of(a.at(0))) out = arithmetic(out, "+", item);
         return out;
       }},
      {"range", range_of},
      {"list", [](const XacroList& a) { return list_from(a.empty() ? XacroList{} : items_of(a[0])); }},
      {"tuple", [](const XacroList& a) { return tuple_from(a.empty() ? XacroList{} : items_of(a[0])); }},
      {"sorted", sorted},
      {"reversed",
       [](const XacroList& a) {
         XacroList items = items_of(a.at(0));
         std::reverse(items.begin(), items.end());
         return list_from(std::move(items));
       }},
      {"zip", zipped},
      {"enumerate",
       [](const XacroList& a) {
         XacroList out;
         for (const XacroValue& item : items_of(a.at(0)))
           out.push_back(tuple_from({static_cast<std::int64_t>(out.size()), item}));
         return list_from(std::move(out));
       }},
      {"any",
       [](const XacroList& a) -> XacroValue {
         const XacroList items = items_of(a.at(0));
         return std::any_of(items.begin(), items.end(), truth_of);
       }},
      {"all",
       [](const XacroList& a) -> XacroValue {
         const XacroList items = items_of(a.at(0));
         return std::all_of(items.begin(), items.end(), truth_of);
       }},
  };
}

const std::map<std::string, Function>& functions() {
  static const std::map<std::string, Function> table = [] {
    std::map<std::string, Function> all = functions_of_numbers();
    all.merge(functions_of_types());
    all.merge(functions_of_lists());
    return all;
  }();
  return table;
}

}  // namespace

bool constant(const std::string& name, XacroValue& out) {
  static const std::map<std::string, double> table = {{"pi", std::numbers::pi},
                                                      {"e", std::numbers::e},
                                                      {"tau", 2 * std::numbers::pi},
                                                      {"inf", std::numeric_limits<double>::infinity()},
                                                      {"nan", std::numeric_limits<double>::quiet_NaN()}};
  const auto found = table.find(name);
  if (found == table.end()) return false;
  out = found->second;
  return true;
}

bool call_builtin(const std::string& name, const XacroList& arguments, XacroValue& out) {
  const auto found = functions().find(name);
  if (found == functions().end()) return false;
  try {
    out = found->second(arguments);
  } catch (const std::out_of_range&) {
    refuse("'" + name + "' was given too few values");
  }
  return true;
}

bool is_builtin(const std::string& name) {
  return functions().contains(name);
}

std::vector<std::string> builtin_names() {
  std::vector<std::string> out;
  for (const auto& [name, function] : functions()) out.push_back(name);
  return out;
}

}  // namespace polyarm::description
