#include "polyarm/description/xacro_functions.hpp"

#include <algorithm>
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
    return std::pow(a, b);
  }
  if (b == 0) refuse("division by zero");
  if (sign == "/") return a / b;
  if (sign == "//") return std::floor(a / b);
  const double rest = std::fmod(a, b);
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
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
  } else {
    return real_arithmetic(static_cast<double>(a), sign, static_cast<double>(b));
  }
  if (overflow) return real_arithmetic(static_cast<double>(a), sign, static_cast<double>(b));
  return out;
}

bool equal(const XacroValue& a, const XacroValue& b) {
  if (a.is_number() && b.is_number()) return number_of(a) == number_of(b);
  if (a.text() && b.text()) return *a.text() == *b.text();
  if (a.list() && b.list())
    return std::equal(a.list()->begin(), a.list()->end(), b.list()->begin(), b.list()->end(), equal);
  if (a.dict() && b.dict()) return repr_of(a) == repr_of(b);
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
  if (in.text()) return item.text() && in.text()->find(*item.text()) != std::string::npos;
  const XacroList items = items_of(in);
  return std::any_of(items.begin(), items.end(), [&](const XacroValue& other) { return equal(other, item); });
}

XacroValue repeated(const XacroValue& what, std::int64_t times) {
  const std::size_t size = what.text() ? what.text()->size() : what.list()->size();
  if (times > 0 && size * static_cast<std::size_t>(times) > kLongest) refuse("the result is too long");
  if (const std::string* text = what.text()) {
    std::string out;
    for (std::int64_t k = 0; k < times; ++k) out += *text;
    return out;
  }
  auto out = std::make_shared<XacroList>();
  for (std::int64_t k = 0; k < times; ++k) out->insert(out->end(), what.list()->begin(), what.list()->end());
  return out;
}

using Function = std::function<XacroValue(const XacroList&)>;

Function real(double (*f)(double)) {
  return [f](const XacroList& a) -> XacroValue {
    if (a.size() != 1) refuse("the function takes one number");
    return f(number_of(a[0]));
  };
}

Function two(double (*f)(double, double)) {
  return [f](const XacroList& a) -> XacroValue {
    if (a.size() != 2) refuse("the function takes two numbers");
    return f(number_of(a[0]), number_of(a[1]));
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

XacroValue rounded(const XacroList& a) {
  const double x = number_of(a.at(0));
  const auto half_even = [](double v) {
    const double r = std::round(v);
    return std::abs(v - std::trunc(v)) == 0.5 ? 2 * std::round(v / 2) : r;
  };
  if (a.size() == 1) {
    if (!(std::abs(x) < 9e18)) refuse("the number cannot be rounded");
    return static_cast<std::int64_t>(half_even(x));
  }
  const double scale = std::pow(10.0, static_cast<double>(int_of(a[1])));
  return half_even(x * scale) / scale;
}

XacroValue range_of(const XacroList& a) {
  if (a.empty() || a.size() > 3) refuse("range takes one to three numbers");
  const std::int64_t begin = a.size() > 1 ? int_of(a[0]) : 0, end = int_of(a[a.size() > 1 ? 1 : 0]);
  const std::int64_t step = a.size() > 2 ? int_of(a[2]) : 1;
  if (step == 0) refuse("the step of a range is 0");
  auto out = std::make_shared<XacroList>();
  for (std::int64_t k = begin; step > 0 ? k < end : k > end; k += step) {
    if (out->size() >= kLongest) refuse("the range is too long");
    out->emplace_back(k);
  }
  return out;
}

XacroValue int_from(const XacroValue& value) {
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

XacroValue list_from(XacroList items) {
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
    out.push_back(list_from(std::move(row)));
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
      {"pow", [](const XacroList& a) { return arithmetic(a.at(0), "**", a.at(1)); }},
      {"radians",
       [](const XacroList& a) -> XacroValue { return number_of(a.at(0)) * (std::numbers::pi / 180); }},
      {"degrees",
       [](const XacroList& a) -> XacroValue { return number_of(a.at(0)) * (180 / std::numbers::pi); }},
      {"floor", [](const XacroList& a) -> XacroValue { return int_of(std::floor(number_of(a.at(0)))); }},
      {"ceil", [](const XacroList& a) -> XacroValue { return int_of(std::ceil(number_of(a.at(0)))); }},
      {"trunc", [](const XacroList& a) -> XacroValue { return int_of(std::trunc(number_of(a.at(0)))); }},
      {"isnan", [](const XacroList& a) -> XacroValue { return std::isnan(number_of(a.at(0))); }},
      {"abs",
       [](const XacroList& a) -> XacroValue {
         return whole(a.at(0)) ? XacroValue(std::abs(int_of(a[0]))) : XacroValue(std::abs(number_of(a[0])));
       }},
      {"round", rounded},
      {"int", [](const XacroList& a) { return int_from(a.at(0)); }},
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
      {"tuple", [](const XacroList& a) { return list_from(a.empty() ? XacroList{} : items_of(a[0])); }},
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
           out.push_back(list_from({static_cast<std::int64_t>(out.size()), item}));
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

XacroValue formatted(const std::string& pattern, const XacroList& values) {
  std::string out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '{') {
      out += pattern[i];
      continue;
    }
    const auto end = pattern.find('}', i);
    if (end == std::string::npos) refuse("a '{' has no partner");
    const std::string inner = pattern.substr(i + 1, end - i - 1);
    const std::size_t which =
        inner.empty() ? next++ : static_cast<std::size_t>(parse_number(inner).value_or(-1));
    if (which >= values.size()) refuse("format has no value for {" + inner + "}");
    out += str_of(values[which]);
    i = end;
  }
  return out;
}

XacroValue text_method(const std::string& text, const std::string& name, const XacroList& a) {
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
  if (name == "upper") {
    std::string out = text;
    std::transform(out.begin(), out.end(), out.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return out;
  }
  if (name == "strip") return strip(true, true);
  if (name == "lstrip") return strip(true, false);
  if (name == "rstrip") return strip(false, true);
  if (name == "startswith") return text.starts_with(argument(0));
  if (name == "endswith") return text.ends_with(argument(0));
  if (name == "find") {
    const auto at = text.find(argument(0));
    return at == std::string::npos ? std::int64_t{-1} : static_cast<std::int64_t>(at);
  }
  if (name == "format") return formatted(text, a);
  if (name == "replace") {
    const std::string from = argument(0), to = argument(1);
    if (from.empty()) refuse("'replace' needs a text to look for");
    std::string out;
    std::size_t begin = 0;
    for (std::size_t at; (at = text.find(from, begin)) != std::string::npos; begin = at + from.size())
      out += text.substr(begin, at - begin) + to;
    return out + text.substr(begin);
  }
  if (name == "join") {
    std::string out;
    bool first = true;
    for (const XacroValue& item : items_of(a.at(0))) {
      if (!std::exchange(first, false)) out += text;
      out += str_of(item);
    }
    return out;
  }
  if (name == "split") {
    XacroList out;
    if (a.empty()) {
      for (const std::string& word : split_words(text)) out.emplace_back(word);
      return list_from(std::move(out));
    }
    const std::string by = argument(0);
    if (by.empty()) refuse("'split' needs a text to split at");
    std::size_t begin = 0;
    for (std::size_t at; (at = text.find(by, begin)) != std::string::npos; begin = at + by.size())
      out.emplace_back(text.substr(begin, at - begin));
    out.emplace_back(text.substr(begin));
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
  if (left.is_number() && right.is_number()) {
    if (whole(left) && whole(right) && sign != "/")
      return whole_arithmetic(int_of(left), sign, int_of(right));
    return real_arithmetic(number_of(left), sign, number_of(right));
  }
  if (sign == "+" && left.text() && right.text()) {
    if (left.text()->size() + right.text()->size() > kLongest) refuse("the text is too long");
    return *left.text() + *right.text();
  }
  if (sign == "+" && left.list() && right.list()) {
    XacroList out = *left.list();
    if (out.size() + right.list()->size() > kLongest) refuse("the list is too long");
    out.insert(out.end(), right.list()->begin(), right.list()->end());
    return list_from(std::move(out));
  }
  if (sign == "*" && (left.text() || left.list()) && whole(right)) return repeated(left, int_of(right));
  if (sign == "*" && (right.text() || right.list()) && whole(left)) return repeated(right, int_of(left));
  if (sign == "%" && left.text()) refuse("% on texts is not understood; use format()");
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
    for (const char c : *text) out.emplace_back(std::string(1, c));
    return out;
  }
  refuse(repr_of(value) + " has no items");
}

XacroValue item_of(const XacroValue& on, const XacroValue& index) {
  if (const XacroDict* dict = on.dict()) {
    for (const auto& [key, value] : *dict)
      if (equal(key, index)) return value;
    refuse("there is no key " + repr_of(index));
  }
  const XacroList items = items_of(on);
  const std::int64_t at = index_in(index, items.size());
  if (at < 0 || at >= static_cast<std::int64_t>(items.size()))
    refuse("there is no item " + repr_of(index) + " among " + std::to_string(items.size()));
  return items[static_cast<std::size_t>(at)];
}

XacroValue slice_of(const XacroValue& on, const XacroValue& begin, const XacroValue& end) {
  const XacroList items = items_of(on);
  const auto n = static_cast<std::int64_t>(items.size());
  const auto place = [&](const XacroValue& index, std::int64_t fallback) {
    if (std::holds_alternative<std::monostate>(index.data)) return fallback;
    return std::clamp(index_in(index, items.size()), std::int64_t{0}, n);
  };
  const std::int64_t from = place(begin, 0), to = std::max(from, place(end, n));
  XacroList out(items.begin() + from, items.begin() + to);
  if (!on.text()) return list_from(std::move(out));
  std::string text;
  for (const XacroValue& letter : out) text += *letter.text();
  return text;
}

XacroValue call_method(const XacroValue& on, const std::string& name, const XacroList& a) {
  if (const std::string* text = on.text()) return text_method(*text, name, a);
  if (const XacroDict* dict = on.dict()) {
    if (name == "get") {
      for (const auto& [key, value] : *dict)
        if (!a.empty() && equal(key, a[0])) return value;
      return a.size() > 1 ? a[1] : XacroValue{};
    }
    XacroList out;
    for (const auto& [key, value] : *dict) {
      if (name == "keys") out.push_back(key);
      if (name == "values") out.push_back(value);
      if (name == "items") out.push_back(list_from({key, value}));
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

}  // namespace polyarm::description
