/// Methods of texts, lists and dictionaries in xacro expressions: "a,b".split(","), and formatted texts.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_functions.hpp"
#include "polyarm/xacro/xacro_parts.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

namespace {

/// A value in a format such as ".3f" or "03d".
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
      ++i;  // a doubled brace is literal
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
      if (out.size() > kLongest) require_short(out.size());
      i = end;
      continue;
    }
    out += c;
  }
  return out;
}

}  // namespace

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
    if (out.size() > kLongest) require_short(out.size());
  }
  if (next < values.size() && !given.dict()) refuse("there are more values than '%'");
  return out;
}

namespace {

bool every(const std::string& text, int (*is)(int)) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](unsigned char c) { return is(c) != 0; });
}

/// A text method and its arguments.
struct TextCall {
  const std::string& text;
  const std::string& name;
  const XacroList& a;
  const std::string& argument(std::size_t i) const {
    if (i >= a.size() || !a[i].text()) refuse("'" + name + "' takes a text");
    spend_on_search(text, *a[i].text());
    return *a[i].text();
  }
};

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// Methods for upper and lower case and for classes of letters.
std::optional<XacroValue> letters_method(const TextCall& call) {
  const auto& [text, name, a] = call;
  if (name == "lower") return lower(text);
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
  return std::nullopt;
}

/// Methods that trim or pad a text.
std::optional<XacroValue> trimming_method(const TextCall& call) {
  const auto& [text, name, a] = call;
  const auto strip = [&call, &text = call.text](bool left, bool right) -> XacroValue {
    const std::string letters = call.a.empty() ? " \t\r\n" : call.argument(0);
    const auto begin = left ? text.find_first_not_of(letters) : 0;
    if (begin == std::string::npos) return std::string();
    const auto end = right ? text.find_last_not_of(letters) + 1 : text.size();
    return text.substr(begin, end - begin);
  };
  if (name == "strip") return strip(true, true);
  if (name == "lstrip") return strip(true, false);
  if (name == "rstrip") return strip(false, true);
  if (name == "removeprefix")
    return text.starts_with(call.argument(0)) ? text.substr(call.argument(0).size()) : text;
  if (name == "removesuffix")
    return text.ends_with(call.argument(0)) ? text.substr(0, text.size() - call.argument(0).size()) : text;
  if (name == "zfill") {
    const std::int64_t width = std::min<std::int64_t>(int_of(a.at(0)), 1000);
    const auto missing = std::max<std::int64_t>(width - static_cast<std::int64_t>(text.size()), 0);
    const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
    return text.substr(0, sign) + std::string(static_cast<std::size_t>(missing), '0') + text.substr(sign);
  }
  return std::nullopt;
}

/// Methods that find or replace a text in another.
std::optional<XacroValue> finding_method(const TextCall& call) {
  const auto& [text, name, a] = call;
  if (name == "count") {
    std::int64_t times = 0;
    const std::string& piece = call.argument(0);
    if (piece.empty()) return static_cast<std::int64_t>(text.size()) + 1;
    for (std::size_t at = 0; (at = text.find(piece, at)) != std::string::npos; at += piece.size()) ++times;
    return times;
  }
  if (name == "startswith") return text.starts_with(call.argument(0));
  if (name == "endswith") return text.ends_with(call.argument(0));
  if (name == "find" || name == "rfind" || name == "index") {
    const auto at = name == "rfind" ? text.rfind(call.argument(0)) : text.find(call.argument(0));
    if (at == std::string::npos && name == "index") refuse(repr_of(a[0]) + " is not in " + repr_of(text));
    return at == std::string::npos ? std::int64_t{-1} : static_cast<std::int64_t>(at);
  }
  if (name == "replace") {
    const std::string from = call.argument(0), to = call.argument(1);
    std::string out;
    if (from.empty()) {  // matches before every letter and at the end
      require_short((text.size() + 1) * (to.size() + 1));
      for (const XacroValue& letter : items_of(text)) out += to + *letter.text();
      return out + to;
    }
    std::size_t begin = 0;
    for (std::size_t at; (at = text.find(from, begin)) != std::string::npos; begin = at + from.size()) {
      out += text.substr(begin, at - begin) + to;
      spend(1 + to.size() / 32);
      if (out.size() > kLongest) require_short(out.size());
    }
    return out + text.substr(begin);
  }
  return std::nullopt;
}

/// Methods that split and join texts.
std::optional<XacroValue> parting_method(const TextCall& call) {
  const auto& [text, name, a] = call;
  if (name == "join") {
    std::string out;
    bool first = true;
    for (const XacroValue& item : items_of(a.at(0))) {
      if (!std::exchange(first, false)) out += text;
      if (!item.text()) refuse("'join' takes texts, not " + repr_of(item));
      out += *item.text();
      if (out.size() > kLongest) require_short(out.size());
    }
    return out;
  }
  if (name == "partition" || name == "rpartition") {
    const std::string& by = call.argument(0);
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
    const std::string by = call.argument(0);
    if (by.empty()) refuse("'split' needs a text to split at");
    std::int64_t most = a.size() > 1 ? int_of(a[1]) : -1;
    std::string rest = text;
    for (std::size_t at; most-- != 0;) {
      spend(1 + rest.size() / 16);  // it is copied
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
  return std::nullopt;
}

XacroValue text_method(const std::string& text, const std::string& name, const XacroList& a,
                       const XacroDict& named) {
  if (name == "format") return formatted(text, a, named);
  for (const auto& method : {letters_method, trimming_method, finding_method, parting_method})
    if (std::optional<XacroValue> value = method({text, name, a})) return *std::move(value);
  refuse("a text has no method '" + name + "'");
}

/// list.pop and dict.pop: they change their object.
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
  refuse("'" + name + "' is not available for " + repr_of(on));
}

}  // namespace

XacroValue call_method(const XacroValue& on, const std::string& name, const XacroList& a,
                       const XacroDict& named) {
  if (!named.empty() && !(on.text() && name == "format")) refuse("'" + name + "' takes no named values");
  if (on.text()) spend(on.text()->size() / 16);
  if (on.dict()) spend(on.dict()->size());
  if (on.list() && (name == "copy" || name == "pop")) spend(on.list()->size());
  try {
    return method_of(on, name, a, named);
  } catch (const std::out_of_range&) {
    refuse("'" + name + "' was given too few values");
  }
}

}  // namespace polyarm::description
