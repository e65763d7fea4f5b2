#include "polyarm/ros_files/python_reader.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace polyarm::ros_files::python {

namespace {

bool is_keyword(const std::string& word) {
  static const std::set<std::string> kWords = {"return", "if",     "elif", "else", "for",  "while",  "in",
                                               "not",    "and",    "or",   "def",  "from", "import", "as",
                                               "with",   "lambda", "try",  "pass", "class"};
  return kWords.contains(word);
}

/// Counts an inner value; false where the outer one would become too heavy.
bool add(Value& to, const Value& inner) {
  if (to.weight + inner.weight > kHeaviest) return false;
  to.weight += inner.weight;
  return true;
}

Value sum(const Value& a, const Value& b) {
  if (a.kind == Value::Kind::list && b.kind == Value::Kind::list) {
    if (a.weight + b.weight > kHeaviest) return {};
    Value out = a;
    out.items.insert(out.items.end(), b.items.begin(), b.items.end());
    out.weight += b.weight;
    return out;
  }
  if (a.kind == Value::Kind::unknown && b.kind == Value::Kind::unknown) return {};
  return Value::of(flat(a) + flat(b));
}

}  // namespace

// --- tokens ---

const PythonToken& PythonReader::token(std::size_t ahead) const {
  static const PythonToken end;
  return at_ + ahead < tokens_.size() ? tokens_[at_ + ahead] : end;
}
bool PythonReader::is(const char* sign, std::size_t ahead) const {
  return token(ahead).kind == PythonToken::Kind::sign && token(ahead).text == sign;
}
bool PythonReader::is_name(std::size_t ahead) const {
  return token(ahead).kind == PythonToken::Kind::name;
}

/// To the bracket that closes what is open at `depth` 0, or to a comma there, or to the end of the text.
void PythonReader::skip_element() {
  for (int depth = 0; at_ < tokens_.size(); ++at_) {
    if (is("(") || is("[") || is("{")) ++depth;
    if (is(")") || is("]") || is("}"))
      if (depth-- == 0) return;
    if (depth == 0 && is(",")) return;
  }
}

// --- statements ---

void PythonReader::statement() {
  if (is_name() && is("=", 1)) {
    const std::string name = token().text;
    at_ += 2;
    const std::size_t begin = at_;
    Value value = expression(0);
    if (at_ == begin) ++at_;
    if (is_name() && token().text == "if") value = {};  // a if c else b
    variables_[name] = std::move(value);
    return;
  }
  const std::size_t begin = at_;
  if (is_name() && !is_keyword(token().text)) expression(0);
  if (at_ == begin) ++at_;
}

// --- expressions ---

Value PythonReader::expression(int depth) {
  if (depth > kDeepest) return {};
  Value out = operand(depth);
  while (is("+") || is("/") || is("%") || is("*") || is("-")) {
    const std::string sign = token().text;
    ++at_;
    const Value other = operand(depth + 1);
    if (sign == "+")
      out = sum(out, other);
    else if (sign == "/" && out.kind != Value::Kind::unknown)
      out = Value::of(joined_path({flat(out, "/"), flat(other, "/")}));
    else
      out = {};
  }
  return out;
}

Value PythonReader::operand(int depth) {
  using Kind = PythonToken::Kind;
  if (token().kind == Kind::string) return strings(depth);
  if (token().kind == Kind::number) return Value::of(tokens_[at_++].text);
  if (is("[")) return followed(sequence("]", depth), depth);
  if (is("(")) return followed(parenthesised(depth), depth);
  if (is("{")) return followed(map(depth), depth);
  if (is_name() && !is_keyword(token().text)) return name(depth);
  return {};
}

/// Literals beside each other are one.
Value PythonReader::strings(int depth) {
  std::string out;
  for (; token().kind == PythonToken::Kind::string; ++at_)
    out += token().formatted ? formatted(token().text) : token().text;
  return followed(Value::of(out), depth);
}

/// f"…{name}…": variables that are known, a gap for what is computed.
std::string PythonReader::formatted(const std::string& text) const {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '{') {
      out += text[i];
      continue;
    }
    const auto end = std::min(text.find('}', i), text.size());
    const auto found = variables_.find(text.substr(i + 1, end - i - 1));
    out += found == variables_.end() ? std::string(1, kUnknown) : flat(found->second);
    i = end;
  }
  return out;
}

Value PythonReader::sequence(const char* close, int depth) {
  Value out;
  out.kind = Value::Kind::list;
  ++at_;
  while (at_ < tokens_.size() && !is(close)) {
    const std::size_t begin = at_;
    Value item = expression(depth + 1);
    if (!is(",") && !is(close)) {  // a condition, a comprehension, a name with =
      skip_element();
      item = {};
    }
    if (add(out, item)) out.items.push_back(std::move(item));
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

/// (x) is x, (x,) and (x, y) are lists.
Value PythonReader::parenthesised(int depth) {
  const std::size_t begin = at_;
  Value list = sequence(")", depth);
  const bool tuple = list.items.size() != 1 ||
                     (at_ >= begin + 2 && at_ - 2 < tokens_.size() && tokens_[at_ - 2].text == ",");
  return tuple ? list : Value(std::move(list.items.front()));
}

Value PythonReader::map(int depth) {
  Value out;
  out.kind = Value::Kind::map;
  ++at_;
  while (at_ < tokens_.size() && !is("}")) {
    const std::size_t begin = at_;
    const Value key = expression(depth + 1);
    if (is(":")) {
      ++at_;
      Value value = expression(depth + 1);
      if (!is(",") && !is("}")) {
        skip_element();
        value = {};
      }
      if (add(out, value)) out.entries.emplace_back(flat(key), std::move(value));
    } else if (!is(",") && !is("}")) {
      skip_element();
    }
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

/// A dotted name, which may be called.
Value PythonReader::name(int depth) {
  const Location where = here();
  std::string last = token().text;
  const std::string first = last;
  std::string whole = last;
  const std::size_t begin = at_++;
  while (is(".") && is_name(1)) {
    last = token(1).text;
    whole += "." + last;
    at_ += 2;
  }
  const auto found = variables_.find(first);
  if (found != variables_.end() && (whole != first || !is("("))) {  // with its methods and attributes
    at_ = begin + 1;
    copied_ += found->second.weight;
    return copied_ > kMostCopied ? Value{} : followed(found->second, depth);
  }
  if (is("(")) return followed(call(whole, last, called_with(depth + 1), where), depth);
  if (whole == "True" || whole == "False") return Value::of(lower(whole));
  return followed(unassigned(whole), depth);
}

/// Methods, attributes and elements of a value.
Value PythonReader::followed(Value value, int depth) {
  if (depth > kDeepest) return {};
  while (is(".") || is("[") || is("(")) {
    if (is("[")) {
      value = indexed(value, depth);
    } else if (is("(")) {
      sequence(")", depth + 1);
      value = {};
    } else {
      const std::string name = token(1).text;
      at_ += 2;
      if (is("(")) {
        const Arguments arguments = called_with(depth + 1);
        value = method(std::move(value), name, &arguments);
      } else {
        value = method(std::move(value), name, nullptr);
      }
    }
  }
  return value;
}

Value PythonReader::indexed(const Value& value, int depth) {
  const Value index = sequence("]", depth + 1);
  if (index.items.size() != 1) return {};
  const std::string key = flat(index.items.front());
  if (value.kind == Value::Kind::map && !has_gap(key))
    if (const Value* found = value.find(key)) return *found;
  if (value.kind == Value::Kind::list && !key.empty() && key.size() < 6 &&
      key.find_first_not_of("0123456789") == std::string::npos)
    if (const auto i = static_cast<std::size_t>(std::stoul(key)); i < value.items.size())
      return value.items[i];
  return {};
}

Arguments PythonReader::called_with(int depth) {
  Arguments out;
  ++at_;
  while (at_ < tokens_.size() && !is(")")) {
    const std::size_t begin = at_;
    const bool named = is_name() && is("=", 1);
    const std::string key = named ? token().text : "";
    if (named) at_ += 2;
    Value value = expression(depth + 1);
    if (!is(",") && !is(")")) {
      skip_element();
      value = {};
    }
    if (named)
      out.named.emplace_back(key, std::move(value));
    else
      out.values.push_back(std::move(value));
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

}  // namespace polyarm::ros_files::python
