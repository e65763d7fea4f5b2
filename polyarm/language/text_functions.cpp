#include "polyarm/language/text_functions.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/data/telling.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/language/rounding.hpp"

namespace polyarm::program {

using data::List;
using data::Number;

namespace {
using Values = std::span<const Value>;
using Names = std::span<const std::string>;

constexpr int kWidest = 200, kMostDigits = 17;

[[noreturn]] void refuse(std::string what, std::string advice = {}) {
  throw OperationError{"bad-value", std::move(what), std::move(advice)};
}

const std::string& string_of(const Value& value) {
  return *value.as_text();
}

std::string quoted(const std::string& text) {
  return "\"" + Value(text).excerpt(40) + "\"";
}

Value checked(std::string text) {
  if (text.size() > kLongestText)
    throw OperationError{"too-large",
                         "this text would have more than " + std::to_string(kLongestText) + " bytes",
                         {}};
  return text;
}

bool starts_letter(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
}

/// The byte at which each letter of a UTF-8 text begins, and the end.
std::vector<std::size_t> letters_of(std::string_view text) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (i == 0 || starts_letter(text[i])) out.push_back(i);
  out.push_back(text.size());
  return out;
}

// format()

[[noreturn]] void refuse_field(std::string_view field) {
  throw OperationError{"bad-format",
                       "'" + std::string(field.substr(0, 40)) + "' is no field of format()",
                       "write {} or such as {:.3f}, {:8}, {:<10}, {:.1mm}"};
}

int digits_at(std::string_view text, std::size_t& at, int most, std::string_view field) {
  int out = 0;
  const std::size_t begin = at;
  for (; at < text.size() && text[at] >= '0' && text[at] <= '9'; ++at)
    if ((out = 10 * out + (text[at] - '0')) > most) refuse_field(field);
  if (at == begin) refuse_field(field);
  return out;
}

bool is_digit_at(std::string_view text, std::size_t at) {
  return at < text.size() && text[at] >= '0' && text[at] <= '9';
}

FormatField field_of(std::string_view field) {
  FormatField out;
  std::string_view spec = field.substr(1, field.size() - 2);
  if (spec.empty()) return out;
  if (spec.front() != ':') refuse_field(field);
  spec.remove_prefix(1);
  std::size_t at = 0;
  if (at < spec.size() && std::string_view("<>^").find(spec[at]) != std::string_view::npos)
    out.align = spec[at++];
  if (is_digit_at(spec, at) && spec[at] == '0') out.zeros = true, ++at;
  if (is_digit_at(spec, at)) out.width = digits_at(spec, at, kWidest, field);
  if (at < spec.size() && spec[at] == '.') out.digits = digits_at(spec, ++at, kMostDigits, field);
  if (at < spec.size() && (spec[at] == 'f' || spec[at] == 'e')) out.style = spec[at++];
  if (at < spec.size() && spec[at] == ' ') ++at;
  out.unit = spec.substr(at);
  if (!out.unit.empty() && !find_unit(out.unit)) refuse_field(field);
  return out;
}

std::string digits_of(double value, const FormatField& field) {
  if (field.style == 0 && field.digits < 0) return shown_text(Value(value));
  const auto format = field.style == 'e' ? std::chars_format::scientific : std::chars_format::fixed;
  constexpr int kUsual = 6;
  std::array<char, 400> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, format,
                                 field.digits < 0 ? kUsual : field.digits);
  return {text.data(), end.ptr};
}

std::string number_text(const Number& number, const FormatField& field) {
  const Unit* unit = field.unit.empty() ? nullptr : find_unit(field.unit);
  if (unit && unit->dimension != number.dimension)
    refuse("format() shall show " + described(Value(number)) + " in " + std::string(field.unit));
  std::string digits = digits_of(number.value / (unit ? unit->scale : 1), field);
  const std::string suffix = unit ? std::string(field.unit) : data::unit_text(number.dimension);
  const std::size_t sign = digits.starts_with('-') ? 1 : 0;
  const std::size_t has = digits.size() + suffix.size(), width = static_cast<std::size_t>(field.width);
  if (field.zeros && has < width) digits.insert(sign, width - has, '0');
  return digits + suffix;
}

std::string field_text(const Value& value, const FormatField& field) {
  const Number* number = value.as_number();
  if (!number && field.of_number())
    refuse("format() has a number there, here is " + described(value), "write {} for it");
  std::string out = number ? number_text(*number, field) : shown_text(value);
  const std::size_t has = letters_of(out).size() - 1, width = static_cast<std::size_t>(field.width);
  if (has >= width) return out;
  const std::size_t blanks = width - has;
  const char align = field.align ? field.align : number ? '>' : '<';
  const std::size_t before = align == '<' ? 0 : align == '>' ? blanks : blanks / 2;
  return std::string(before, ' ') + out + std::string(blanks - before, ' ');
}

Value format_of(Values a, Names) {
  const std::string& text = string_of(a[0]);
  const std::vector<FormatField> fields = format_fields(text);
  if (fields.size() != a.size() - 1)
    refuse(wrong_values(fields.size(), a.size() - 1));
  std::string out;
  std::size_t at = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out.append(text, at, fields[i].begin - at);
    out += field_text(a[i + 1], fields[i]);
    at = fields[i].end;
    if (out.size() > kLongestText) break;
  }
  return checked(out.append(text, at));
}

// Numbers and texts.

/// "12.5", "12.5mm"; empty: no number.
std::optional<Number> number_in(std::string_view text) {
  text = trim(text);
  if (const auto bare = parse_number(text)) return Number{*bare, Dimension::none};
  for (std::size_t end = text.size(); end-- > 1;) {  // "m/s2" ends in a digit
    const Unit* unit = find_unit(trim(text.substr(end)));
    const auto number = unit ? parse_number(text.substr(0, end)) : std::nullopt;
    if (number && std::isfinite(*number * unit->scale)) return Number{*number * unit->scale, unit->dimension};
  }
  return std::nullopt;
}

Value number_of(Values a, Names) {
  constexpr std::size_t kLongest = 100;
  const std::string& text = string_of(a[0]);
  const auto out = text.size() <= kLongest ? number_in(text) : std::nullopt;
  if (!out) refuse(quoted(text) + " is no number", "is_number() says whether a text is one");
  return *out;
}

Value is_number_of(Values a, Names) {
  constexpr std::size_t kLongest = 100;
  return string_of(a[0]).size() <= kLongest && number_in(string_of(a[0])).has_value();
}

Value text_of(Values a, Names) {
  return checked(shown_text(a[0]));
}

Value split_of(Values a, Names) {
  const std::string &whole = string_of(a[0]), &by = string_of(a[1]);
  if (by.empty()) refuse("split() needs to know by what", "write split(line, \",\")");
  List out;
  for (std::size_t at = 0;;) {
    const std::size_t end = whole.find(by, at);
    out.emplace_back(whole.substr(at, end == std::string::npos ? end : end - at));
    if (out.size() > kMostListItems) refuse("split() would make more than " + std::to_string(kMostListItems) + " texts");
    if (end == std::string::npos) return make_list(std::move(out));
    at = end + by.size();
  }
}

Value join_of(Values a, Names) {
  std::string out;
  const List& parts = *a[0].as_list();
  for (std::size_t i = 0; i < parts.size() && out.size() <= kLongestText; ++i)
    out += (i ? string_of(a[1]) : std::string{}) + shown_text(parts[i]);
  return checked(std::move(out));
}

Value trim_of(Values a, Names) {
  return std::string(trim(string_of(a[0])));
}

template <char kFirst, char kLast, int kBy>
Value change_case(Values a, Names) {
  std::string out = string_of(a[0]);
  for (char& c : out)
    if (c >= kFirst && c <= kLast) c = static_cast<char>(c + kBy);
  return out;
}

Value find_of(Values a, Names) {
  if (const List* list = a[0].as_list()) {
    const auto at =
        std::find_if(list->begin(), list->end(), [&](const Value& each) { return equal_values(each, a[1]); });
    return at == list->end() ? Value(0) : Value(static_cast<double>(at - list->begin()) + 1);
  }
  if (!a[1].as_text()) refuse("find() looks for a text in a text, here is " + described(a[1]));
  const std::string& whole = string_of(a[0]);
  const std::size_t at = whole.find(string_of(a[1]));
  if (at == std::string::npos) return 0;
  return 1 + static_cast<double>(std::count_if(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at), starts_letter));
}

Value replace_of(Values a, Names) {
  const std::string &whole = string_of(a[0]), &old = string_of(a[1]), &by = string_of(a[2]);
  if (old.empty()) refuse("replace() needs to know what to replace");
  std::string out;
  for (std::size_t at = 0; out.size() <= kLongestText;) {
    const std::size_t end = whole.find(old, at);
    out.append(whole, at, end == std::string::npos ? end : end - at);
    if (end == std::string::npos) return checked(std::move(out));
    out += by;
    at = end + old.size();
  }
  return checked(std::move(out));
}

/// A place counted from 1, or from the end: -1 is the last.
double place_of(const Value& value, std::size_t size) {
  const double n = unrounded(value.as_number()->value);
  if (!is_whole(n) || n == 0) refuse("slice() counts from 1, or from -1 backwards, here is " + value.text());
  return n < 0 ? n + static_cast<double>(size) + 1 : n;
}

Value slice_of(Values a, Names) {
  const List* list = a[0].as_list();
  const std::vector<std::size_t> letters = list ? std::vector<std::size_t>{} : letters_of(string_of(a[0]));
  const std::size_t size = list ? list->size() : letters.size() - 1;
  const double first = std::max(1.0, place_of(a[1], size));
  const double last = std::min(static_cast<double>(size), place_of(a[2], size));
  const bool none = first > last;
  const std::size_t begin = none ? 0 : static_cast<std::size_t>(first) - 1,
                    end = none ? 0 : static_cast<std::size_t>(last);
  if (!list) return string_of(a[0]).substr(none ? 0 : letters[begin], none ? 0 : letters[end] - letters[begin]);
  return make_list(List(list->begin() + static_cast<std::ptrdiff_t>(begin),
                        list->begin() + static_cast<std::ptrdiff_t>(end)));
}
}  // namespace

std::string shown_text(const Value& value) {
  std::string out;
  data::ValueWriter telling(value, data::kShownDigits);
  while (!telling.go_on(out, kLongestText) && out.size() <= kLongestText) continue;
  return out;
}

std::string wrong_values(std::size_t fields, std::size_t values) {
  const auto counted = [](std::size_t count, const std::string& what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
  };
  return "format() has " + counted(fields, "field") + " and " + counted(values, "value");
}

std::vector<FormatField> format_fields(std::string_view text) {
  std::vector<FormatField> out;
  for (std::size_t at = text.find('{'); at != std::string_view::npos; at = text.find('{', out.back().end)) {
    const std::size_t close = text.find('}', at);
    if (close == std::string_view::npos) refuse_field(text.substr(at));
    out.push_back(field_of(text.substr(at, close + 1 - at)));
    out.back().begin = at, out.back().end = close + 1;
  }
  return out;
}

void add_text_functions(std::vector<Function>& out) {
  using W = Wanted;
  const auto gives = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                         std::vector<FunctionParameter> parameters, std::optional<data::Kind> kind, auto call) {
    out.push_back({name, signature, meaning, std::move(parameters), false, false, kind, {}, call});
  };
  const FunctionParameter text_{"text", W::text, {}};
  gives("format", "format(text, a, b, …)",
        "the text with the values in its fields: {} as log() shows it, {:.3f} with three decimals, {:8} 8 wide, {:<8} to "
        "the left, {:06.2f} with zeros, {:.1mm} in a unit",
        {text_, {"value", W::any, {}}}, data::Kind::text, &format_of);
  out.back().more = true;
  gives("text", "text(value)", "the value as a text, as log() shows it", {{"value", W::any, {}}}, data::Kind::text, &text_of);
  gives("number", "number(text)", "the number in a text, with its unit if it has one; an error if it is none",
        {text_}, data::Kind::number, &number_of);
  gives("is_number", "is_number(text)", "true if number() can read the text", {text_}, data::Kind::boolean, &is_number_of);
  gives("split", "split(text, by)", "the parts of a text between each `by`, as a list", {text_, {"by", W::text, {}}},
        data::Kind::list, &split_of);
  gives("join", "join(list, by)", "one text of all values of a list, with `by` between them",
        {{"list", W::list, {}}, {"by", W::text, {}}}, data::Kind::text, &join_of);
  gives("trim", "trim(text)", "without blanks at its ends", {text_}, data::Kind::text, &trim_of);
  gives("upper", "upper(text)", "with a to z as A to Z", {text_}, data::Kind::text, &change_case<'a', 'z', 'A' - 'a'>);
  gives("lower", "lower(text)", "with A to Z as a to z", {text_}, data::Kind::text, &change_case<'A', 'Z', 'a' - 'A'>);
  gives("find", "find(whole, part)", "where a text has `part` first, or a list the value; counted from 1, 0 if nowhere",
        {{"whole", W::list_or_text, {}}, {"part", W::any, {}}}, data::Kind::number, &find_of);
  out.back().dimension = Dimension::none;
  gives("replace", "replace(text, old, new)", "with `new` for each `old`",
        {text_, {"old", W::text, {}}, {"new", W::text, {}}}, data::Kind::text, &replace_of);
  gives("slice", "slice(whole, first, last)",
        "a part of a text or a list, with its first and last place; -1 is the last one", 
        {{"whole", W::list_or_text, {}}, {"first", W::scalar, {}}, {"last", W::scalar, -1.0}}, {}, &slice_of);
}

}  // namespace polyarm::program
