#include "polyarm/description/xacro_functions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

constexpr std::size_t kLongest = 1'000'000;

[[noreturn]] void refuse(const std::string& what) {
  throw Error("bad-expression", what);
}

bool whole(const XacroValue& value) {
  return std::holds_alternative<std::int64_t>(value.data) || std::holds_alternative<bool>(value.data);
}

std::int64_t int_of(const XacroValue& value) {
  if (const auto* flag = std::get_if<bool>(&value.data)) return *flag;
  if (const auto* number = std::get_if<std::int64_t>(&value.data)) return *number;
  if (const auto* real = std::get_if<double>(&value.data); real && std::abs(*real) < 9e18)
    return static_cast<std::int64_t>(*real);
  refuse(repr_of(value) + " is not a whole number");
}

std::int64_t index_in(const XacroValue& index, std::size_t size) {
  if (!whole(index)) refuse(repr_of(index) + " is no place in a list");
  const std::int64_t at = int_of(index);
  return at < 0 ? at + static_cast<std::int64_t>(size) : at;
}

XacroValue real_arithmetic(double a, const std::string& sign, double b) {
  if (sign == "+") return a + b;
  if (sign == "-") return a - b;
  if (sign == "*") return a * b;
  if (sign == "**") {
    if (a == 0 && b < 0) refuse("0 to a negative power");
    const double out = std::pow(a, b);
    if (std::isnan(out) && !std::isnan(a) && !std::isnan(b)) refuse("a negative number to a broken power");
    if (std::isinf(out) && std::isfinite(a) && std::isfinite(b)) refuse("the result is too large");
    return out;
  }
  if (b == 0) refuse("division by zero");
  if (sign == "/") return a / b;
  double rest = std::fmod(a, b), whole_part = (a - rest) / b;
  if (rest != 0 && (rest < 0) != (b < 0)) rest += b, whole_part -= 1;
  if (sign == "%") return rest == 0 ? std::copysign(0.0, b) : rest;
  return std::abs(whole_part) < 0.5 ? std::copysign(0.0, a / b) : std::round(whole_part);
}

XacroValue whole_arithmetic(std::int64_t a, const std::string& sign, std::int64_t b) {
  std::int64_t out = 0;
  bool overflow = false;
  if (sign == "+")
    overflow = __builtin_add_overflow(a, b, &out);
  else if (sign == "-")
    overflow = __builtin_sub_overflow(a, b, &out);
  else if (sign == "*")
    overflow = __builtin_mul_overflow(a, b, &out);
  else if (sign == "**" && b >= 0 && b < 64) {
    out = 1;
    for (std::int64_t k = 0; k < b && !overflow; ++k) overflow = __builtin_mul_overflow(out, a, &out);
  } else if ((sign == "//" || sign == "%") && b != 0 && !(a == INT64_MIN && b == -1)) {
    std::int64_t quotient = a / b, rest = a % b;
    if (rest != 0 && (rest < 0) != (b < 0)) --quotient, rest += b;
    return sign == "%" ? rest : quotient;
  } else if (sign == "&" || sign == "|" || sign == "^") {
    return sign == "&" ? a & b : sign == "|" ? a | b : a ^ b;
  } else if (sign == "<<" || sign == ">>") {
    if (b < 0 || b > 62) refuse("a shift by " + std::to_string(b));
    if (sign == ">>") return a >> b;
    overflow = __builtin_mul_overflow(a, std::int64_t{1} << b, &out);
  } else {
    return real_arithmetic(static_cast<double>(a), sign, static_cast<double>(b));
  }
  if (overflow) return real_arithmetic(static_cast<double>(a), sign, static_cast<double>(b));
  return out;
}

bool equal(const XacroValue& a, const XacroValue& b);

const XacroValue* value_at(const XacroDict& dict, const XacroValue& key) {
  for (const auto& [own, value] : dict)
    if (equal(own, key)) return &value;
  return nullptr;
}

bool equal(const XacroValue& a, const XacroValue& b) {
  if (a.is_number() && b.is_number()) return number_of(a) == number_of(b);
  if (a.text() && b.text()) return *a.text() == *b.text();
  if (a.list() && b.list())
    return a.list()->is_tuple == b.list()->is_tuple &&
           std::equal(a.list()->begin(), a.list()->end(), b.list()->begin(), b.list()->end(), equal);
  if (a.dict() && b.dict())
    return a.dict()->size() == b.dict()->size() &&
           std::all_of(a.dict()->begin(), a.dict()->end(), [&](const auto& item) {
             const XacroValue* other = value_at(*b.dict(), item.first);
             return other && equal(item.second, *other);
           });
  if (const auto* function = std::get_if<XacroFunction>(&a.data))
    return std::holds_alternative<XacroFunction>(b.data) &&
           function->name == std::get<XacroFunction>(b.data).name;
  return a.data.index() == b.data.index() && std::holds_alternative<std::monostate>(a.data);
}

bool less(const XacroValue& a, const XacroValue& b) {
  if (a.is_number() && b.is_number()) return number_of(a) < number_of(b);
  if (a.text() && b.text()) return *a.text() < *b.text();
  if (a.list() && b.list())
    return std::lexicographical_compare(a.list()->begin(), a.list()->end(), b.list()->begin(),
                                        b.list()->end(), less);
  refuse(repr_of(a) + " and " + repr_of(b) + " cannot be compared");
}

bool contains(const XacroValue& in, const XacroValue& item) {
  if (in.text() && !item.text()) refuse(repr_of(item) + " cannot be in a text");
  if (in.text()) return in.text()->find(*item.text()) != std::string::npos;
  const XacroList items = items_of(in);
  return std::any_of(items.begin(), items.end(), [&](const XacroValue& other) { return equal(other, item); });
}

XacroValue repeated(const XacroValue& what, std::int64_t times) {
  const std::size_t size = size_of(what);
  if (size == 0 || times < 0) times = 0;
  if (size > 0 && static_cast<std::size_t>(times) > kLongest / size) refuse("the result is too long");
  if (const std::string* text = what.text()) {
    std::string out;
    for (std::int64_t k = 0; k < times; ++k) out += *text;
    return out;
  }
  auto out = std::make_shared<XacroList>();
  out->is_tuple = what.list()->is_tuple;
  for (std::int64_t k = 0; k < times; ++k) out->insert(out->end(), what.list()->begin(), what.list()->end());
  return out;
}

/// What is put together stays of a size that can be held.
void require_short(std::size_t size) {
  if (size > kLongest) refuse("the result is too long");
}

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

/// min and max: of the arguments, or of the one list.
XacroValue extreme(const XacroList& given, bool largest) {
  const XacroList items = given.size() == 1 ? items_of(given[0]) : given;
  if (items.empty()) refuse("there is nothing to choose from");
  const XacroValue* best = &items.front();
  for (const XacroValue& item : items)
    if (largest ? less(*best, item) : less(item, *best)) best = &item;
  return *best;
}

/// To the nearest, halves to the even one; digits are those of the number as it is stored.
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

XacroValue tuple_from(XacroList items) {
  items.is_tuple = true;
  return std::make_shared<XacroList>(std::move(items));
}

XacroValue list_from(XacroList items) {
  items.is_tuple = false;
  return std::make_shared<XacroList>(std::move(items));
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

/// Each item once, in the order in which they came.
XacroValue set_of(const XacroList& items) {
  XacroList out;
  for (const XacroValue& item : items)
    if (!std::any_of(out.begin(), out.end(), [&](const XacroValue& other) { return equal(other, item); }))
      out.push_back(item);
  return list_from(std::move(out));
}

/// What sets do; also where an item stands twice.
XacroValue set_arithmetic(const XacroList& a, const std::string& sign, const XacroList& b) {
  const auto within = [](const XacroList& list) {
    return [&list](const XacroValue& item) {
      return std::any_of(list.begin(), list.end(),
                         [&](const XacroValue& other) { return equal(other, item); });
    };
  };
  XacroList out = a;
  if (sign == "&")
    std::erase_if(out, [&](const XacroValue& item) { return !within(b)(item); });
  else if (sign != "|")
    std::erase_if(out, within(b));
  if (sign == "|" || sign == "^")
    std::copy_if(b.begin(), b.end(), std::back_inserter(out),
                 [&](const XacroValue& item) { return !within(a)(item); });
  return set_of(out);
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

/// map() and filter(): the function's value of each item, or the items for which it is true.
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

const std::map<std::string, Function>& functions() {
  static const std::map<std::string, Function> table = {
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
  return table;
}

/// A value as a format like ".3f" or "03d" says.
std::string shown_as(const XacroValue& value, const std::string& format) {
  if (format.empty()) return str_of(value);
  std::size_t digits = 0, longest = 0;
  for (const char c : format)
    longest = std::max(longest, digits = std::isdigit(static_cast<unsigned char>(c)) ? digits + 1 : 0);
  if (longest > 3 || format.find_first_of("{}") != std::string::npos)
    refuse("the format '" + format + "' is not understood");
  const std::string pattern = "{:" + format + "}";
  try {
    const bool real = std::string_view("eEfFgG%").find(format.back()) != std::string_view::npos;
    if (std::holds_alternative<double>(value.data) || (real && value.is_number()))
      return fmt::format(fmt::runtime(pattern), number_of(value));
    if (value.is_number()) return fmt::format(fmt::runtime(pattern), int_of(value));
    return fmt::format(fmt::runtime(pattern), str_of(value));
  } catch (const fmt::format_error& e) {
    refuse("the format '" + format + "' does not go with " + repr_of(value));
  }
}

/// "{} {1} {name:.2f}".format(…)
XacroValue formatted(const std::string& pattern, const XacroList& values, const XacroDict& named) {
  std::string out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char c = pattern[i];
    if ((c == '{' || c == '}') && i + 1 < pattern.size() && pattern[i + 1] == c)
      ++i;  // doubled: itself
    else if (c == '{') {
      const auto end = pattern.find('}', i);
      if (end == std::string::npos) refuse("a '{' has no partner");
      const std::string inner = pattern.substr(i + 1, end - i - 1), name = inner.substr(0, inner.find(':'));
      const std::string format = name.size() < inner.size() ? inner.substr(name.size() + 1) : "";
      const bool is_number = name.find_first_not_of("0123456789") == std::string::npos && name.size() < 6;
      const std::size_t place = !is_number ? values.size() : name.empty() ? next++ : std::stoul(name);
      const XacroValue* value = place < values.size() ? &values[place] : value_at(named, name);
      if (!value) refuse("format has no value for {" + inner + "}");
      out += shown_as(*value, format);
      i = end;
      continue;
    }
    out += c;
  }
  return out;
}

/// "%d of %s" % values
XacroValue filled_in(const std::string& pattern, const XacroValue& given) {
  const XacroList values = given.list() && given.list()->is_tuple ? *given.list() : XacroList{given};
  std::string out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '%') {
      out += pattern[i];
      continue;
    }
    const auto kind = pattern.find_first_not_of("+-# .0123456789", i + 1);
    if (kind == std::string::npos) refuse("a '%' has no letter");
    std::string format = pattern.substr(i + 1, kind - i - 1);
    i = kind;
    if (pattern[kind] == '%') {
      out += '%';
      continue;
    }
    if (std::string_view("diufFeEgGsrxX").find(pattern[kind]) == std::string_view::npos)
      refuse(std::string("'%") + pattern[kind] + "' is not understood");
    if (next >= values.size()) refuse("there are more '%' than values");
    const XacroValue& value = values[next++];
    const bool text = pattern[kind] == 's' || pattern[kind] == 'r';
    const bool is_whole = std::string_view("diuxX").find(pattern[kind]) != std::string_view::npos;
    if (text || format.starts_with('-'))
      format = format.starts_with('-') ? "<" + format.substr(1) : format.empty() ? "" : ">" + format;
    if (text)
      out += shown_as(pattern[kind] == 's' ? str_of(value) : repr_of(value), format);
    else
      out += shown_as(is_whole ? XacroValue(int_of(value)) : XacroValue(number_of(value)),
                      format + (pattern[kind] == 'i' || pattern[kind] == 'u' ? 'd' : pattern[kind]));
  }
  if (next < values.size() && !given.dict()) refuse("there are more values than '%'");
  return out;
}

bool every(const std::string& text, int (*is)(int)) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](unsigned char c) { return is(c) != 0; });
}

XacroValue text_method(const std::string& text, const std::string& name, const XacroList& a,
                       const XacroDict& named) {
  const auto argument = [&](std::size_t i) -> const std::string& {
    if (i >= a.size() || !a[i].text()) refuse("'" + name + "' takes a text");
    return *a[i].text();
  };
  const auto strip = [&](bool left, bool right) -> XacroValue {
    const std::string letters = a.empty() ? " \t\r\n" : argument(0);
    const auto begin = left ? text.find_first_not_of(letters) : 0;
    if (begin == std::string::npos) return std::string();
    const auto end = right ? text.find_last_not_of(letters) + 1 : text.size();
    return text.substr(begin, end - begin);
  };
  if (name == "lower") return lower(text);
  const auto upper = [](std::string some) {
    std::transform(some.begin(), some.end(), some.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return some;
  };
  if (name == "upper") return upper(text);
  if (name == "capitalize")
    return upper(text.substr(0, 1)) + lower(text.substr(std::min<std::size_t>(1, text.size())));
  if (name == "title") {
    std::string out = lower(text);
    for (std::size_t i = 0; i < out.size(); ++i)
      if (i == 0 || !std::isalpha(static_cast<unsigned char>(out[i - 1])))
        out[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(out[i])));
    return out;
  }
  if (name == "isdigit" || name == "isnumeric" || name == "isdecimal") return every(text, std::isdigit);
  if (name == "isalpha") return every(text, std::isalpha);
  if (name == "isalnum") return every(text, std::isalnum);
  if (name == "isspace") return every(text, std::isspace);
  if (name == "islower") return text != upper(text) && text == lower(text);
  if (name == "isupper") return text != lower(text) && text == upper(text);
  if (name == "removeprefix") return text.starts_with(argument(0)) ? text.substr(argument(0).size()) : text;
  if (name == "removesuffix")
    return text.ends_with(argument(0)) ? text.substr(0, text.size() - argument(0).size()) : text;
  if (name == "zfill") {
    const std::int64_t width = std::min<std::int64_t>(int_of(a.at(0)), 1000);
    const auto missing = std::max<std::int64_t>(width - static_cast<std::int64_t>(text.size()), 0);
    const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
    return text.substr(0, sign) + std::string(static_cast<std::size_t>(missing), '0') + text.substr(sign);
  }
  if (name == "count") {
    std::int64_t times = 0;
    const std::string& piece = argument(0);
    if (piece.empty()) return static_cast<std::int64_t>(text.size()) + 1;
    for (std::size_t at = 0; (at = text.find(piece, at)) != std::string::npos; at += piece.size()) ++times;
    return times;
  }
  if (name == "strip") return strip(true, true);
  if (name == "lstrip") return strip(true, false);
  if (name == "rstrip") return strip(false, true);
  if (name == "startswith") return text.starts_with(argument(0));
  if (name == "endswith") return text.ends_with(argument(0));
  if (name == "find" || name == "rfind" || name == "index") {
    const auto at = name == "rfind" ? text.rfind(argument(0)) : text.find(argument(0));
    if (at == std::string::npos && name == "index") refuse(repr_of(a[0]) + " is not in " + repr_of(text));
    return at == std::string::npos ? std::int64_t{-1} : static_cast<std::int64_t>(at);
  }
  if (name == "format") return formatted(text, a, named);
  if (name == "replace") {
    const std::string from = argument(0), to = argument(1);
    std::string out;
    if (from.empty()) {  // stands before every letter and at the end
      require_short((text.size() + 1) * (to.size() + 1));
      for (const XacroValue& letter : items_of(text)) out += to + *letter.text();
      return out + to;
    }
    std::size_t begin = 0;
    for (std::size_t at; (at = text.find(from, begin)) != std::string::npos; begin = at + from.size()) {
      out += text.substr(begin, at - begin) + to;
      require_short(out.size());
    }
    return out + text.substr(begin);
  }
  if (name == "join") {
    std::string out;
    bool first = true;
    for (const XacroValue& item : items_of(a.at(0))) {
      if (!std::exchange(first, false)) out += text;
      if (!item.text()) refuse("'join' takes texts, not " + repr_of(item));
      out += *item.text();
      require_short(out.size());
    }
    return out;
  }
  if (name == "partition" || name == "rpartition") {
    const std::string& by = argument(0);
    const auto at = name == "partition" ? text.find(by) : text.rfind(by);
    if (by.empty()) refuse("'" + name + "' needs a text to split at");
    if (at != std::string::npos) return tuple_from({text.substr(0, at), by, text.substr(at + by.size())});
    const std::string none;
    return name == "partition" ? tuple_from({text, none, none}) : tuple_from({none, none, text});
  }
  if (name == "split" || name == "rsplit") {
    XacroList out;
    if (a.empty() || std::holds_alternative<std::monostate>(a[0].data)) {
      for (const std::string& word : split_words(text)) out.emplace_back(word);
      return list_from(std::move(out));
    }
    const std::string by = argument(0);
    if (by.empty()) refuse("'split' needs a text to split at");
    std::int64_t most = a.size() > 1 ? int_of(a[1]) : -1;
    std::string rest = text;
    for (std::size_t at; most-- != 0;) {
      at = name == "split" ? rest.find(by) : rest.rfind(by);
      if (at == std::string::npos) break;
      const std::string after = rest.substr(at + by.size()), before = rest.substr(0, at);
      out.emplace_back(name == "split" ? before : after);
      rest = name == "split" ? after : before;
    }
    out.emplace_back(rest);
    if (name == "rsplit") std::reverse(out.begin(), out.end());
    return list_from(std::move(out));
  }
  refuse("a text has no method '" + name + "'");
}

}  // namespace

double number_of(const XacroValue& value) {
  if (const auto* flag = std::get_if<bool>(&value.data)) return *flag ? 1 : 0;
  if (const auto* number = std::get_if<std::int64_t>(&value.data)) return static_cast<double>(*number);
  if (const auto* real_number = std::get_if<double>(&value.data)) return *real_number;
  refuse(repr_of(value) + " is not a number");
}

XacroValue arithmetic(const XacroValue& left, const std::string& sign, const XacroValue& right) {
  if (sign == "neg") {
    if (whole(right)) return whole_arithmetic(0, "-", int_of(right));
    return -number_of(right);
  }
  if (sign == "~" && whole(right)) return ~int_of(right);
  const bool bits = sign == "&" || sign == "|" || sign == "^" || sign == "<<" || sign == ">>";
  if (left.is_number() && right.is_number()) {
    if (whole(left) && whole(right) && sign != "/")
      return whole_arithmetic(int_of(left), sign, int_of(right));
    if (!bits) return real_arithmetic(number_of(left), sign, number_of(right));
  }
  if (sign == "+" && left.text() && right.text()) {
    require_short(left.text()->size() + right.text()->size());
    return *left.text() + *right.text();
  }
  if (left.list() && right.list() && (sign == "-" || sign == "&" || sign == "|" || sign == "^"))
    return set_arithmetic(*left.list(), sign, *right.list());
  if (sign == "|" && left.dict() && right.dict()) {
    auto out = std::make_shared<XacroDict>(*left.dict());
    for (const auto& [key, value] : *right.dict()) set_key(*out, key, value);
    return out;
  }
  if (sign == "+" && left.list() && right.list() && left.list()->is_tuple == right.list()->is_tuple) {
    require_short(size_of(left) + size_of(right));
    XacroList out = *left.list();
    out.insert(out.end(), right.list()->begin(), right.list()->end());
    return out.is_tuple ? tuple_from(std::move(out)) : list_from(std::move(out));
  }
  if (sign == "*" && (left.text() || left.list()) && whole(right)) return repeated(left, int_of(right));
  if (sign == "*" && (right.text() || right.list()) && whole(left)) return repeated(right, int_of(left));
  if (sign == "%" && left.text()) return filled_in(*left.text(), right);
  refuse("'" + sign + "' does not go with " + repr_of(left) + " and " + repr_of(right));
}

bool compare(const XacroValue& left, const std::string& sign, const XacroValue& right) {
  if (sign == "==" || sign == "is") return equal(left, right);
  if (sign == "!=" || sign == "is not") return !equal(left, right);
  if (sign == "in") return contains(right, left);
  if (sign == "not in") return !contains(right, left);
  if (sign == "<") return less(left, right);
  if (sign == ">") return less(right, left);
  return sign == "<=" ? !less(right, left) : !less(left, right);
}

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

XacroList items_of(const XacroValue& value) {
  if (value.list()) return *value.list();
  XacroList out;
  if (const XacroDict* dict = value.dict()) {
    for (const auto& [key, item] : *dict) out.push_back(key);
    return out;
  }
  if (const std::string* text = value.text()) {
    for (const char c : *text)  // letters of UTF-8
      if ((static_cast<unsigned char>(c) & 0xC0) == 0x80 && !out.empty())
        std::get<std::string>(out.back().data) += c;
      else
        out.emplace_back(std::string(1, c));
    return out;
  }
  refuse(repr_of(value) + " has no items");
}

XacroValue item_of(const XacroValue& on, const XacroValue& index) {
  if (const XacroDict* dict = on.dict()) {
    if (const XacroValue* value = value_at(*dict, index)) return *value;
    refuse("there is no key " + repr_of(index));
  }
  const XacroList items = items_of(on);
  const std::int64_t at = index_in(index, items.size());
  if (at < 0 || at >= static_cast<std::int64_t>(items.size()))
    refuse("there is no item " + repr_of(index) + " among " + std::to_string(items.size()));
  return items[static_cast<std::size_t>(at)];
}

XacroValue slice_of(const XacroValue& on, const XacroValue& begin, const XacroValue& end,
                    const XacroValue& step) {
  const XacroList items = items_of(on);
  const auto n = static_cast<std::int64_t>(items.size());
  const std::int64_t by = std::holds_alternative<std::monostate>(step.data) ? 1 : int_of(step);
  if (by == 0) refuse("the step of a slice is 0");
  const std::int64_t low = by > 0 ? 0 : -1, high = by > 0 ? n : n - 1;
  const auto place = [&](const XacroValue& index, std::int64_t fallback) {
    if (std::holds_alternative<std::monostate>(index.data)) return fallback;
    return std::clamp(index_in(index, items.size()), low, high);
  };
  const std::int64_t to = place(end, by > 0 ? high : low);
  XacroList out;
  for (std::int64_t at = place(begin, by > 0 ? low : high); by > 0 ? at < to : at > to;) {
    out.push_back(items[static_cast<std::size_t>(at)]);
    if (__builtin_add_overflow(at, by, &at)) break;
  }
  if (on.list() && on.list()->is_tuple) return tuple_from(std::move(out));
  if (!on.text()) return list_from(std::move(out));
  std::string text;
  for (const XacroValue& letter : out) text += *letter.text();
  return text;
}

int depth_of(const XacroValue& value) {
  int out = 0;
  if (value.list())
    for (const XacroValue& item : *value.list()) out = std::max(out, depth_of(item));
  if (value.dict())
    for (const auto& [key, item] : *value.dict()) out = std::max(out, depth_of(item));
  return out + 1;
}

std::size_t size_of(const XacroValue& value) {
  if (value.text()) return value.text()->size();
  std::size_t out = 0;
  if (value.list())
    for (const XacroValue& item : *value.list()) out += 1 + size_of(item);
  if (value.dict())
    for (const auto& [key, item] : *value.dict()) out += 2 + size_of(key) + size_of(item);
  return out;
}

void set_key(XacroDict& dict, const XacroValue& key, XacroValue value) {
  for (auto& [own, old] : dict)
    if (equal(own, key)) {
      old = std::move(value);
      return;
    }
  dict.emplace_back(key, std::move(value));
}

namespace {

/// list.pop and dict.pop: they change what they are asked of.
XacroValue popped(const XacroValue& on, const XacroList& a) {
  if (const auto* list = std::get_if<std::shared_ptr<XacroList>>(&on.data)) {
    XacroList& items = **list;
    const std::int64_t at =
        a.empty() ? static_cast<std::int64_t>(items.size()) - 1 : index_in(a[0], items.size());
    if (at < 0 || at >= static_cast<std::int64_t>(items.size())) refuse("there is no such item to pop");
    XacroValue out = std::move(items[static_cast<std::size_t>(at)]);
    items.erase(items.begin() + at);
    return out;
  }
  XacroDict& dict = *std::get<std::shared_ptr<XacroDict>>(on.data);
  const auto found =
      std::find_if(dict.begin(), dict.end(), [&](const auto& own) { return equal(own.first, a.at(0)); });
  if (found == dict.end() && a.size() > 1) return a[1];
  if (found == dict.end()) refuse("there is no key " + repr_of(a.at(0)) + " to pop");
  XacroValue out = std::move(found->second);
  dict.erase(found);
  return out;
}

XacroValue method_of(const XacroValue& on, const std::string& name, const XacroList& a,
                     const XacroDict& named) {
  if (const std::string* text = on.text()) return text_method(*text, name, a, named);
  if (name == "pop" && (on.list() || on.dict())) return popped(on, a);
  if (name == "copy" && (on.list() || on.dict()))
    return on.list() ? list_from(*on.list()) : XacroValue(std::make_shared<XacroDict>(*on.dict()));
  if (const XacroDict* dict = on.dict()) {
    if (name == "get") {
      if (const XacroValue* value = value_at(*dict, a.at(0))) return *value;
      return a.size() > 1 ? a[1] : XacroValue{};
    }
    XacroList out;
    for (const auto& [key, value] : *dict) {
      if (name == "keys") out.push_back(key);
      if (name == "values") out.push_back(value);
      if (name == "items") out.push_back(tuple_from({key, value}));
    }
    if (name == "keys" || name == "values" || name == "items") return list_from(std::move(out));
  }
  if (on.list() && (name == "index" || name == "count") && a.size() == 1) {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < on.list()->size(); ++i)
      if (equal((*on.list())[i], a[0])) {
        if (name == "index") return static_cast<std::int64_t>(i);
        ++count;
      }
    if (name == "count") return count;
    refuse(repr_of(a[0]) + " is not in the list");
  }
  refuse("'" + name + "' cannot be asked of " + repr_of(on));
}

}  // namespace

XacroValue call_method(const XacroValue& on, const std::string& name, const XacroList& a,
                       const XacroDict& named) {
  if (!named.empty() && !(on.text() && name == "format")) refuse("'" + name + "' takes no named values");
  try {
    return method_of(on, name, a, named);
  } catch (const std::out_of_range&) {
    refuse("'" + name + "' was given too few values");
  }
}

}  // namespace polyarm::description
