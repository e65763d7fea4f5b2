#include "polyarm/xacro/xacro_functions.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <utility>
#include <variant>

#include "polyarm/xacro/xacro_parts.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

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
  if (!whole(index)) refuse(repr_of(index) + " is not a place in a list");
  const std::int64_t at = int_of(index);
  return at < 0 ? at + static_cast<std::int64_t>(size) : at;
}

const XacroValue* value_at(const XacroDict& dict, const XacroValue& key) {
  for (const auto& [own, value] : dict)
    if (equal(own, key)) return &value;
  return nullptr;
}

bool equal(const XacroValue& a, const XacroValue& b) {
  spend(1);
  if (a.is_number() && b.is_number()) return number_of(a) == number_of(b);
  if (a.text() && b.text()) return spend(a.text()->size() / 64), *a.text() == *b.text();
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
  spend(3);
  if (a.is_number() && b.is_number()) return number_of(a) < number_of(b);
  if (a.text() && b.text()) return spend(a.text()->size() / 64), *a.text() < *b.text();
  if (a.list() && b.list())
    return std::lexicographical_compare(a.list()->begin(), a.list()->end(), b.list()->begin(),
                                        b.list()->end(), less);
  refuse(repr_of(a) + " and " + repr_of(b) + " cannot be compared");
}

void require_short(std::size_t size) {
  spend(size / 32);
  if (size > kLongest) refuse("the result is too long");
}

XacroValue tuple_from(XacroList items) {
  items.is_tuple = true;
  return std::make_shared<XacroList>(std::move(items));
}

XacroValue list_from(XacroList items) {
  items.is_tuple = false;
  return std::make_shared<XacroList>(std::move(items));
}

namespace {
/// Items, keys or letters.
std::size_t length_of(const XacroValue& value) {
  return value.list() ? value.list()->size() : value.dict() ? value.dict()->size() : value.text() ? value.text()->size() : 0;
}
}  // namespace

XacroValue set_of(const XacroList& items) {
  XacroList out;
  for (const XacroValue& item : items)
    if (!std::any_of(out.begin(), out.end(), [&](const XacroValue& other) { return equal(other, item); }))
      out.push_back(item);
  return list_from(std::move(out));
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

namespace {

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

bool contains(const XacroValue& in, const XacroValue& item) {
  if (in.text() && !item.text()) refuse(repr_of(item) + " cannot be in a text");
  if (in.text()) return spend_on_search(*in.text(), *item.text()), in.text()->find(*item.text()) != std::string::npos;
  const XacroList items = items_of(in);
  return std::any_of(items.begin(), items.end(), [&](const XacroValue& other) { return equal(other, item); });
}

XacroValue repeated(const XacroValue& what, std::int64_t times) {
  const std::size_t size = size_of(what);
  if (size == 0 || times < 0) times = 0;
  if (times > 0 && static_cast<std::size_t>(times) <= kLongest / size) spend(1 + size * static_cast<std::size_t>(times));
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

/// Set operators; duplicate items are allowed.
XacroValue set_arithmetic(const XacroList& a, const std::string& sign, const XacroList& b) {
  const auto within = [](const XacroList& list) {
    return [&list](const XacroValue& item) {
      return std::any_of(list.begin(), list.end(),
                         [&](const XacroValue& other) { return equal(other, item); });
    };
  };
  spend(a.size() + b.size());
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
    spend(left.dict()->size());
    auto out = std::make_shared<XacroDict>(*left.dict());
    for (const auto& [key, value] : *right.dict()) set_key(*out, key, value);
    return out;
  }
  if (sign == "+" && left.list() && right.list() && left.list()->is_tuple == right.list()->is_tuple) {
    require_short(size_of(left) + size_of(right));
    spend(left.list()->size() + right.list()->size());
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

XacroList items_of(const XacroValue& value) {
  spend(1 + (value.text() ? 6 : 1) * length_of(value));  // each letter becomes a text of its own
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
  spend(1);
  int out = 0;
  if (value.list())
    for (const XacroValue& item : *value.list()) out = std::max(out, depth_of(item));
  if (value.dict())
    for (const auto& [key, item] : *value.dict()) out = std::max(out, depth_of(item));
  return out + 1;
}

std::size_t size_of(const XacroValue& value) {
  spend(1);
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

}  // namespace polyarm::description
