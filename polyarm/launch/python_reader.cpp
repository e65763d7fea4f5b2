/// Reads expressions. Lists and maps are in python_collections.cpp, statements in python_statements.cpp.
#include "polyarm/launch/python_reader.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/launch/python_methods.hpp"

namespace polyarm::ros_files::python {

namespace {

/// The action of a launch file that calls a function with the launch context and more arguments.
constexpr const char* kCaller = "OpaqueFunction";

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

Value of_known(Known value) {
  return value == Known::open ? Value{} : Value::truth(value == Known::yes);
}
Known inverted(Known value) {
  return value == Known::open ? value : value == Known::yes ? Known::no : Known::yes;
}

Known equal(const Value& a, const Value& b) {
  if (a.kind != Value::Kind::text || b.kind != Value::Kind::text || has_gap(a.text + b.text))
    return Known::open;
  return a.text == b.text ? Known::yes : Known::no;
}

Known contained(const Value& part, const Value& whole) {
  if (part.kind != Value::Kind::text || has_gap(part.text)) return Known::open;
  if (whole.kind == Value::Kind::text && !has_gap(whole.text))
    return whole.text.find(part.text) != std::string::npos ? Known::yes : Known::no;
  if (whole.kind == Value::Kind::map) return whole.find(part.text) ? Known::yes : Known::open;
  if (whole.kind != Value::Kind::list) return Known::open;
  Known out = Known::no;
  for (const Value& item : whole.items) {
    const Known same = equal(part, item);
    if (same == Known::yes) return same;
    if (same == Known::open) out = same;
  }
  return out;
}

}  // namespace

Known known(const Value& value) {
  if (value.kind == Value::Kind::list) return value.items.empty() ? Known::no : Known::yes;
  if (value.kind != Value::Kind::text || has_gap(value.text)) return Known::open;
  const std::string text = lower(value.text);
  return text.empty() || text == "false" || text == "0" || text == "none" ? Known::no : Known::yes;
}

PythonReader::PythonReader(std::string_view text, std::string file) : file_{std::move(file)}, main_{text} {
  for (std::size_t i = 0; i + 1 < main_.tokens.size(); ++i) {
    const bool defined = i > 0 && main_.tokens[i - 1].text == "def";
    if (main_.tokens[i].kind != PythonToken::Kind::name || main_.tokens[i + 1].text != "(" || defined)
      continue;
    called_.insert(main_.tokens[i].text);
    if (main_.tokens[i].text == kCaller) called_.insert(function_given(i + 1));
  }
}

// --- tokens ---

const PythonToken& PythonReader::token(std::size_t ahead) const {
  static const PythonToken end;
  return at_ + ahead < source_->tokens.size() ? source_->tokens[at_ + ahead] : end;
}
bool PythonReader::is(const char* sign, std::size_t ahead) const {
  return token(ahead).kind == PythonToken::Kind::sign && token(ahead).text == sign;
}
bool PythonReader::is_name(std::size_t ahead) const {
  return token(ahead).kind == PythonToken::Kind::name;
}
bool PythonReader::is_word(const char* word, std::size_t ahead) const {
  return is_name(ahead) && token(ahead).text == word;
}

bool PythonReader::may_repeat(const Location& where) {
  if (steps_ < kMostSteps) return true;
  left_out(where, "loops and functions are too much to read from here on");
  return false;
}

/// Skips to the closing bracket, to a comma before it, or to the end of the line. It is not known whether
/// calls in between happen.
void PythonReader::skip_element(int depth) {
  const Unsure unsure(unsure_, true);
  const std::size_t begin = at_;
  while (at_ < source_->tokens.size() && !is(",") && !is(")") && !is("]") && !is("}")) {
    if (at_ > begin && token().first) return;
    const bool opens = is("(") || is("[") || is("{");
    const std::size_t before = at_;
    if (opens && depth > kDeepest)
      at_ = source_->close[at_];
    else if (depth <= kDeepest)
      operand(depth + 1);
    if (at_ == before || (opens && depth > kDeepest)) ++at_;
  }
}

/// The first such word in this element, outside brackets; 0: none.
std::size_t PythonReader::find_word(const char* word) const {
  for (std::size_t i = at_; i < source_->tokens.size(); ++i) {
    const PythonToken& t = source_->tokens[i];
    if (i > at_ && t.first) return 0;
    if (t.kind == PythonToken::Kind::name) {
      if (t.text == word) return i;
      if (t.text == "for" || t.text == "lambda") return 0;
    }
    if (t.kind != PythonToken::Kind::sign) continue;
    if (t.text == "(" || t.text == "[" || t.text == "{") {
      i = source_->close[i];
    } else if (t.text == "," || t.text == ")" || t.text == "]" || t.text == "}" || t.text == ":" ||
               t.text == "=") {
      return 0;
    }
  }
  return 0;
}

// --- expressions ---

Value PythonReader::expression(int depth) {
  if (depth > kDeepest) return {};
  if (const std::size_t condition = find_word("if"); condition > at_) return either(condition, depth);
  return disjunction(depth);
}

/// A if C else B: reads only A or B if C is known; else reads both, and the value is unknown.
Value PythonReader::either(std::size_t condition, int depth) {
  const std::size_t begin = at_;
  at_ = condition + 1;
  const Known choice = known(disjunction(depth + 1));
  const bool otherwise = is_word("else");
  const std::size_t after = at_;
  Value first, second;
  {
    const Unsure unsure(unsure_, choice == Known::open);
    if (choice != Known::no) {
      at_ = begin;
      first = disjunction(depth + 1);
    }
    at_ = after + (otherwise ? 1 : 0);
    if (choice == Known::yes) {  // skips B, whose calls do not happen
      while (at_ < source_->tokens.size() && !is(",") && !is(")") && !is("]") && !is("}") &&
             !(at_ > after && token().first) && !is_word("for"))
        at_ =
            std::min((is("(") || is("[") || is("{") ? source_->close[at_] : at_) + 1, source_->tokens.size());
    } else if (otherwise) {
      second = expression(depth + 1);
    }
  }
  return choice == Known::yes ? first : choice == Known::no ? second : Value{};
}

Value PythonReader::disjunction(int depth) {
  Value out = conjunction(depth);
  while (is_word("or")) {
    ++at_;
    const Known first = known(out);
    const Unsure unsure(unsure_, first == Known::open);
    const Value other = conjunction(depth + 1);
    if (first == Known::no) out = other;
    if (first == Known::open) out = known(other) == Known::yes ? Value::gap() : Value{};
  }
  return out;
}

Value PythonReader::conjunction(int depth) {
  Value out = comparison(depth);
  while (is_word("and")) {
    ++at_;
    const Known first = known(out);
    const Unsure unsure(unsure_, first == Known::open);
    const Value other = comparison(depth + 1);
    if (first == Known::yes) out = other;
    if (first == Known::open) out = known(other) == Known::no ? other : Value{};
  }
  return out;
}

Value PythonReader::comparison(int depth) {
  bool negated = false;
  bool any = false;
  for (; is_word("not"); ++at_) {
    negated = !negated;
    any = true;
  }
  Value left = sum_of(depth);
  for (;;) {
    const bool same = is("==") || (is_word("is") && !is_word("not", 1));
    const bool other = is("!=") || (is_word("is") && is_word("not", 1));
    const bool in = is_word("in"), not_in = is_word("not") && is_word("in", 1);
    const bool order = is("<") || is(">") || is("<=") || is(">=");
    if (!same && !other && !in && !not_in && !order) break;
    at_ += not_in || (other && is_word("is")) ? 2 : 1;
    const Value right = sum_of(depth + 1);
    const Known result = order ? Known::open : in || not_in ? contained(left, right) : equal(left, right);
    left = of_known(other || not_in ? inverted(result) : result);
  }
  return any ? of_known(negated ? inverted(known(left)) : known(left)) : left;
}

Value PythonReader::sum_of(int depth) {
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
    else if (sign == "%" && out.kind == Value::Kind::text)
      out = filled_percent(out.text, other);
    else
      out = {};
  }
  return out;
}

Value PythonReader::operand(int depth) {
  using Kind = PythonToken::Kind;
  ++steps_;
  if (token().kind == Kind::string) return strings(depth);
  if (token().kind == Kind::number) return Value::of(source_->tokens[at_++].text);
  if (is("[")) return followed(sequence("]", depth), depth);
  if (is("(")) return followed(parenthesised(depth), depth);
  if (is("{")) return followed(map(depth), depth);
  if (is_word("lambda")) return lambda(depth);
  if (is("-") && token(1).kind == Kind::number) {
    at_ += 2;
    return Value::of("-" + source_->tokens[at_ - 1].text);
  }
  if (is_name() && !is_keyword(token().text)) return name(depth);
  return {};
}

/// Adjacent literals are joined.
Value PythonReader::strings(int depth) {
  std::string out;
  while (token().kind == PythonToken::Kind::string) {
    const PythonToken& part = token();
    ++at_;
    out += part.formatted ? formatted(part.text, part.line, depth + 1) : part.text;
    if (token().first) break;
  }
  return followed(Value::of(out), depth);
}

/// f"…{expression}…"; computed parts become gaps.
std::string PythonReader::formatted(const std::string& text, int line, int depth) {
  return with_fields(text, [&](std::size_t begin, std::string& out) {
    const std::size_t end = end_of_insertion(text, begin);
    out += flat(inserted(text.substr(begin + 1, end - begin - 1), line, depth));
    return end;
  });
}

/// The value between the braces of f"…{…}…".
Value PythonReader::inserted(const std::string& text, int line, int depth) {
  if (depth > kDeepest / 2) return Value::gap();
  const auto found = variables_.find(text);
  if (found != variables_.end()) return found->second;
  PythonSource inner(text);
  for (PythonToken& token : inner.tokens) token.line += line - 1;
  const PythonSource* const outer = std::exchange(source_, &inner);
  const std::size_t at = std::exchange(at_, 0);
  Value out = expression(depth + 1);
  if (is("!") && is_name(1)) at_ += 2;
  if (at_ < inner.tokens.size()) out = Value::gap();  // a width or an operator follows
  source_ = outer;
  at_ = at;
  return out;
}

/// The result, as if it were called once.
Value PythonReader::lambda(int depth) {
  while (at_ < source_->tokens.size() && !is(":") && !is(")") && !is("]") && !is("}")) ++at_;
  if (!is(":")) return {};
  ++at_;
  return expression(depth + 1);
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
  if (found != variables_.end() && (whole != first || !is("("))) {  // a variable
    at_ = begin + 1;
    copied_ += found->second.weight;
    return copied_ > kMostCopied ? Value{} : followed(found->second, depth);
  }
  if (is("(")) return followed(called(whole, last, where, depth), depth);
  if (whole == "True" || whole == "False") return Value::of(lower(whole));
  return followed(unassigned(whole), depth);
}

/// Reads a call. Its condition= decides whether calls inside its brackets happen.
Value PythonReader::called(const std::string& whole, const std::string& last, const Location& where,
                           int depth) {
  const std::string condition = condition_ahead(depth + 1);
  if (condition == "false") {
    at_ = std::min(source_->close[at_] + 1, source_->tokens.size());
    return {};
  }
  const std::size_t open = at_;
  Arguments arguments;
  {
    const Unsure unsure(unsure_, condition != "true");
    arguments = called_with(depth + 1);
  }
  if (last == kCaller) {
    const Unsure unsure(unsure_, condition != "true");
    call_given(function_given(open), arguments, depth);
  }
  if (const auto value = function_of_python(last, arguments)) return *value;
  const auto function = functions_.find(last);
  if (function == functions_.end() || whole != last) return call(whole, last, arguments, where);
  const Value out = run(function->second, arguments, depth);
  const Value other = call(whole, last, arguments, where);
  return out.kind == Value::Kind::unknown ? other : out;
}

/// NAME of `function=NAME` in the call that opens at the token `open`; empty if there is none.
std::string PythonReader::function_given(std::size_t open) const {
  const auto& tokens = source_->tokens;
  const std::size_t end = std::min(source_->close[open], tokens.size());
  for (std::size_t i = open + 1; i + 2 < end; ++i) {
    const bool sign = tokens[i].kind == PythonToken::Kind::sign;
    if (tokens[i].text == "function" && tokens[i + 1].text == "=" &&
        tokens[i + 2].kind == PythonToken::Kind::name)
      return tokens[i + 2].text;
    if (sign && (tokens[i].text == "(" || tokens[i].text == "[" || tokens[i].text == "{"))
      i = source_->close[i];
  }
  return {};
}

/// Reads the function for OpaqueFunction(function=NAME, args=[…], kwargs={…}). The launch context, its first
/// argument, has no value.
void PythonReader::call_given(const std::string& name, const Arguments& given, int depth) {
  const auto function = functions_.find(name);
  if (function == functions_.end()) return;
  Arguments arguments;
  arguments.values.emplace_back();
  if (const Value* more = given.find("args"))
    arguments.values.insert(arguments.values.end(), more->items.begin(), more->items.end());
  if (const Value* named = given.find("kwargs")) arguments.named = named->entries;
  run(function->second, arguments, depth);
}

/// The value of condition= in the call; "true" if there is none.
std::string PythonReader::condition_ahead(int depth) {
  const std::size_t begin = at_, end = std::min(source_->close[at_], source_->tokens.size());
  std::string out = "true";
  for (std::size_t i = at_ + 1; i + 2 < end; ++i) {
    const PythonToken& t = source_->tokens[i];
    if (t.kind == PythonToken::Kind::name && t.text == "condition" && source_->tokens[i + 1].text == "=") {
      at_ = i + 2;
      const Value value = expression(depth);
      out = value.kind == Value::Kind::text ? flat(value) : std::string(1, kUnknown);
      if (value.kind == Value::Kind::text && value.text == "none") out = "true";
      break;
    }
    if (t.kind == PythonToken::Kind::sign && (t.text == "(" || t.text == "[" || t.text == "{"))
      i = source_->close[i];
  }
  at_ = begin;
  return out;
}

/// Methods, attributes and elements of a value.
Value PythonReader::followed(Value value, int depth) {
  if (depth > kDeepest) return {};
  while ((is(".") || is("[") || is("(")) && !token().first) {
    if (is("[")) {
      value = indexed(value, depth);
    } else if (is("(")) {
      called_with(depth + 1);
      value = {};
    } else {
      const std::string name = token(1).text;
      const Location where = here();
      at_ += 2;
      if (is("(")) {
        const Arguments arguments = called_with(depth + 1);
        const auto plain = method_of_text(value, name, arguments);
        value = plain ? *plain : method(std::move(value), name, &arguments, where);
      } else {
        value = method(std::move(value), name, nullptr, where);
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
  const bool last = key == "-1" && !value.items.empty();
  if (value.kind == Value::Kind::list && last) return value.items.back();
  if (value.kind == Value::Kind::list && !key.empty() && key.size() < 6 &&
      key.find_first_not_of("0123456789") == std::string::npos)
    if (const auto i = static_cast<std::size_t>(std::stoul(key)); i < value.items.size())
      return value.items[i];
  return {};
}

Arguments PythonReader::called_with(int depth) {
  Arguments out;
  if (source_->loop[at_] > 0) {  // f(x for x in list)
    out.values.push_back(sequence(")", depth));
    return out;
  }
  ++at_;
  while (at_ < source_->tokens.size() && !is(")")) {
    const std::size_t begin = at_;
    const bool named = is_name() && is("=", 1);
    const std::string key = named ? token().text : "";
    if (named) at_ += 2;
    const int spread = is("*") ? (is("*", 1) ? 2 : 1) : 0;
    at_ += static_cast<std::size_t>(spread);
    Value value = expression(depth + 1);
    if (!is(",") && !is(")")) {
      skip_element(depth + 1);
      value = {};
    }
    if (named)
      out.named.emplace_back(key, std::move(value));
    else if (spread == 2)
      out.named.insert(out.named.end(), value.entries.begin(), value.entries.end());
    else if (spread == 1)
      out.values.insert(out.values.end(), value.items.begin(), value.items.end());
    else
      out.values.push_back(std::move(value));
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

}  // namespace polyarm::ros_files::python
