#include "polyarm/launch/python_methods.hpp"

#include <algorithm>
#include <cctype>

namespace polyarm::ros_files::python {

namespace {

constexpr std::size_t kLongestRange = 1000;

Value list_of(std::vector<Value> items) {
  Value out;
  out.kind = Value::Kind::list;
  for (Value& item : items) {
    if (out.weight + item.weight > kHeaviest) break;
    out.weight += item.weight;
    out.items.push_back(std::move(item));
  }
  return out;
}

/// The items of a list, or the keys of a map.
std::optional<std::vector<Value>> items_of(const Value& value) {
  if (value.kind == Value::Kind::list) return value.items;
  if (value.kind != Value::Kind::map) return std::nullopt;
  std::vector<Value> out;
  for (const auto& [key, inner] : value.entries) out.push_back(Value::of(key));
  return out;
}

std::optional<std::size_t> index_of(const Value& value) {
  const std::string text = flat(value);
  if (text.empty() || text.size() > 4 || text.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return static_cast<std::size_t>(std::stoul(text));
}

Value range(const Arguments& a) {
  std::vector<std::size_t> numbers;
  for (const Value& value : a.values)
    if (const auto number = index_of(value))
      numbers.push_back(*number);
    else
      return {};
  if (numbers.empty() || numbers.size() > 3) return {};
  const std::size_t begin = numbers.size() > 1 ? numbers[0] : 0, end = numbers[numbers.size() > 1 ? 1 : 0];
  const std::size_t step = numbers.size() > 2 ? numbers[2] : 1;
  if (step == 0) return {};
  std::vector<Value> out;
  for (std::size_t i = begin; i < end && out.size() < kLongestRange; i += step)
    out.push_back(Value::of(std::to_string(i)));
  return list_of(std::move(out));
}

Value zipped(const Arguments& a) {
  std::vector<std::vector<Value>> lists;
  for (const Value& value : a.values)
    if (auto items = items_of(value))
      lists.push_back(std::move(*items));
    else
      return {};
  if (lists.empty()) return {};
  std::size_t size = lists.front().size();
  for (const auto& list : lists) size = std::min(size, list.size());
  std::vector<Value> out;
  for (std::size_t i = 0; i < size; ++i) {
    std::vector<Value> row;
    for (const auto& list : lists) row.push_back(list[i]);
    out.push_back(list_of(std::move(row)));
  }
  return list_of(std::move(out));
}

Value enumerated(const std::vector<Value>& items) {
  std::vector<Value> out;
  for (const Value& item : items) out.push_back(list_of({Value::of(std::to_string(out.size())), item}));
  return list_of(std::move(out));
}

Value formatted(const std::string& text, const Arguments& a) {
  std::size_t next = 0;
  return Value::of(with_fields(text, [&](std::size_t begin, std::string& out) {
    const std::size_t end = std::min(text.find('}', begin), text.size());
    const std::string field = text.substr(begin + 1, end - begin - 1);
    const auto index = field.empty() ? std::optional<std::size_t>(next++) : index_of(Value::of(field));
    const Value* value = index ? (*index < a.values.size() ? &a.values[*index] : nullptr) : a.find(field);
    out += value ? flat(*value) : std::string(1, kUnknown);
    return end;
  }));
}

Value replaced(std::string text, const std::string& from, const std::string& to) {
  if (from.empty()) return Value::of(text);
  for (std::size_t at = text.find(from); at != std::string::npos && text.size() <= kLongestText;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return Value::of(text);
}

}  // namespace

Value filled_percent(const std::string& text, const Value& with) {
  std::string out;
  std::size_t next = 0;
  const bool many = with.kind == Value::Kind::list;
  for (std::size_t i = 0; i < text.size() && out.size() <= kLongestText; ++i) {
    if (text[i] != '%' || i + 1 == text.size()) {
      out += text[i];
      continue;
    }
    const char form = text[++i];
    if (form == '%')
      out += '%';
    else if (form == 's' || form == 'd' || form == 'i' || form == 'f')
      out += !many && next++ == 0               ? flat(with)
             : many && next < with.items.size() ? flat(with.items[next++])
                                                : std::string(1, kUnknown);
    else
      return Value::gap();
  }
  return Value::of(out);
}

std::size_t end_of_insertion(const std::string& text, std::size_t from) {
  int depth = 0;
  char quote = 0;
  for (std::size_t i = from + 1; i < text.size(); ++i) {
    const char c = text[i];
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '(' || c == '[' || c == '{') {
      ++depth;
    } else if (c == '}' && depth == 0) {
      return i;
    } else if (c == ')' || c == ']' || c == '}') {
      --depth;
    }
  }
  return text.size();
}

std::optional<Value> function_of_python(const std::string& name, const Arguments& a) {
  if (name == "range") return range(a);
  if (name == "zip") return zipped(a);
  if (a.values.empty()) return std::nullopt;
  const bool is_list = name == "list" || name == "tuple" || name == "sorted" || name == "reversed";
  if (!is_list && name != "enumerate") return std::nullopt;
  auto items = items_of(a.values.front());
  if (!items) return Value{};
  if (name == "enumerate") return enumerated(*items);
  if (name == "reversed") std::reverse(items->begin(), items->end());
  if (name == "sorted")
    std::stable_sort(items->begin(), items->end(),
                     [](const Value& x, const Value& y) { return flat(x) < flat(y); });
  return list_of(std::move(*items));
}

std::optional<Value> method_of_text(const Value& value, const std::string& name, const Arguments& a) {
  if (value.kind == Value::Kind::map && name == "keys") return list_of(*items_of(value));
  if (value.kind == Value::Kind::map && name == "values") {
    std::vector<Value> out;
    for (const auto& [key, inner] : value.entries) out.push_back(inner);
    return list_of(std::move(out));
  }
  if (value.kind != Value::Kind::text) return std::nullopt;
  const std::string& text = value.text;
  const std::string first = a.values.empty() ? "" : flat(a.values.front());
  if (name == "format") return formatted(text, a);
  if (name == "join") return a.values.empty() ? Value{} : Value::of(flat(a.values.front(), text));
  if (name == "joinpath") {
    std::vector<std::string> parts{text};
    for (const Value& part : a.values) parts.push_back(flat(part));
    return Value::of(joined_path(parts));
  }
  if (has_gap(text)) return std::nullopt;
  if (name == "lower" || name == "casefold") return Value::of(lower(text));
  if (name == "upper") {
    std::string out = text;
    for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return Value::of(out);
  }
  if (has_gap(first)) return std::nullopt;
  if (name == "strip" && a.values.empty()) return Value::of(std::string(trim(text)));
  if (name == "startswith") return Value::truth(text.starts_with(first));
  if (name == "endswith") return Value::truth(text.ends_with(first));
  if (name == "replace" && a.values.size() == 2 && !has_gap(flat(a.values[1])))
    return replaced(text, first, flat(a.values[1]));
  if (name == "split") {
    std::vector<Value> out;
    for (const std::string& word : split_words(text, a.values.empty() ? " \t\r\n" : first))
      out.push_back(Value::of(word));
    return list_of(std::move(out));
  }
  return std::nullopt;
}

}  // namespace polyarm::ros_files::python
