/// Reads Python statements: blocks, assignments, conditions, loops and functions of the file.
#include <algorithm>
#include <utility>

#include "polyarm/launch/python_reader.hpp"

namespace polyarm::ros_files::python {

PythonReader::Bound::Bound(std::map<std::string, Value>& variables, const std::vector<std::string>& names)
    : variables_{variables} {
  for (const std::string& name : names) {
    const auto found = variables.find(name);
    before_.emplace_back(name, found == variables.end() ? std::nullopt : std::optional(found->second));
  }
}
PythonReader::Bound::~Bound() {
  for (auto& [name, value] : before_)
    if (value)
      variables_[name] = std::move(*value);
    else
      variables_.erase(name);
}

// --- blocks ---

void PythonReader::block(std::size_t end, int depth) {
  while (at_ < end && at_ < source_->tokens.size()) {
    const std::size_t begin = at_;
    statement(depth);
    if (at_ == begin) ++at_;
  }
}

void PythonReader::statement(int depth) {
  if (depth > kDeepest) {
    at_ = source_->line_end[at_];
    return;
  }
  if (is_word("async")) ++at_;
  if (!compound(depth)) simple(source_->line_end[at_]);
}

bool PythonReader::compound(int depth) {
  if (is_word("def")) return define(depth), true;
  if (is_word("if")) return choose(depth), true;
  if (is_word("for") || is_word("while")) return loop(depth), true;
  if (is_word("with")) return with(depth), true;
  const bool sure = is_word("try") || is_word("else") || is_word("finally") || is_word("class");
  const bool maybe = is_word("except") || is_word("elif") || is_word("match") || is_word("case");
  if (!sure && !maybe) return false;
  const std::size_t begin = body_begin(at_), end = body_end(at_, begin);
  if (begin >= source_->tokens.size() || begin == at_) return false;
  const Unsure unsure(unsure_, maybe);
  at_ = begin;
  block(end, depth + 1);
  return true;
}

/// The token after the ':' of a compound statement; `from` if there is none.
std::size_t PythonReader::body_begin(std::size_t from) const {
  const auto& tokens = source_->tokens;
  for (std::size_t i = from; i < tokens.size(); ++i) {
    if (i > from && tokens[i].first) break;
    const std::string& text = tokens[i].text;
    if (tokens[i].kind == PythonToken::Kind::name && text == "lambda") break;
    if (tokens[i].kind != PythonToken::Kind::sign) continue;
    if (text == ":") return i + 1;
    if (text == "(" || text == "[" || text == "{") i = source_->close[i];
  }
  return from;
}

/// The first line that is not indented more than the statement.
std::size_t PythonReader::body_end(std::size_t statement, std::size_t begin) const {
  const auto& tokens = source_->tokens;
  if (begin >= tokens.size()) return tokens.size();
  if (!tokens[begin].first) return source_->line_end[begin];  // if a: b
  std::size_t at = begin;
  while (at < tokens.size() && tokens[at].column > tokens[statement].column) at = source_->line_end[at];
  return at;
}

// --- conditions and loops ---

/// if … elif … else: skips the branches that are known not to be taken.
void PythonReader::choose(int depth) {
  bool decided = false, open = false;
  const int column = token().column;
  for (bool first = true; at_ < source_->tokens.size(); first = false) {
    const bool condition = is_word("if") || is_word("elif"), otherwise = is_word("else");
    if (!first && (is_word("if") || (!condition && !otherwise) || token().column != column)) return;
    const std::size_t begin = body_begin(at_), end = body_end(at_, begin);
    if (begin == at_) return;
    Known choice = Known::yes;
    ++at_;
    if (decided)
      choice = Known::no;
    else if (condition)
      choice = known(expression(depth + 1));
    if (choice != Known::no) {
      const Unsure unsure(unsure_, open || choice == Known::open);
      at_ = begin;
      block(end, depth + 1);
    }
    decided = decided || choice == Known::yes;
    open = open || choice == Known::open;
    at_ = end;
    if (otherwise) return;
  }
}

/// The names before `end_word`: a, (b, c)
std::vector<std::string> PythonReader::targets(const char* end_word) {
  std::vector<std::string> out;
  while (at_ < source_->tokens.size() && !is_word(end_word) && !is(":") && out.size() < 20) {
    if (is_name() && !is_keyword(token().text)) out.push_back(token().text);
    ++at_;
  }
  if (is_word(end_word)) ++at_;
  return out;
}

void PythonReader::bind(const std::vector<std::string>& names, const Value& value) {
  copied_ += value.weight;
  if (names.size() == 1) {
    variables_[names.front()] = copied_ > kMostCopied ? Value{} : value;
    return;
  }
  const bool fits = value.kind == Value::Kind::list && value.items.size() == names.size();
  for (std::size_t i = 0; i < names.size(); ++i)
    variables_[names[i]] = fits && copied_ <= kMostCopied ? value.items[i] : Value{};
}

/// The items of a list, or the keys of a map; with two names, the pairs of the map.
std::vector<Value> PythonReader::rounds(const Value& over, std::size_t names) {
  if (over.kind == Value::Kind::list) return over.items;
  std::vector<Value> out;
  for (const auto& [key, value] : over.entries) {
    if (names < 2) {
      out.push_back(Value::of(key));
      continue;
    }
    Value pair;
    pair.kind = Value::Kind::list;
    pair.items = {Value::of(key), value};
    pair.weight = 2 + value.weight;
    out.push_back(std::move(pair));
  }
  return out;
}

void PythonReader::loop(int depth) {
  const Location where = here();
  const std::size_t begin = body_begin(at_), end = body_end(at_, begin);
  if (begin == at_) {
    ++at_;
    return;
  }
  const bool is_for = is_word("for");
  ++at_;
  std::vector<std::string> names;
  Value over;
  if (is_for) {
    names = targets("in");
    over = expression(depth + 1);
  }
  const bool is_known = over.kind == Value::Kind::list || over.kind == Value::Kind::map;
  std::vector<Value> all = is_known ? rounds(over, names.size()) : std::vector<Value>(1);
  if (all.size() > kMostRounds) left_out(where, "only the first 200 rounds of a loop are read");
  all.resize(std::min<std::size_t>(all.size(), kMostRounds));
  const Unsure unsure(unsure_, !is_known);
  for (const Value& value : all) {
    if (!may_repeat(where)) break;
    bind(names, value);
    at_ = begin;
    block(end, depth + 1);
  }
  at_ = end;
}

/// with EXPRESSION as NAME:
void PythonReader::with(int depth) {
  const std::size_t begin = body_begin(at_), end = body_end(at_, begin);
  ++at_;
  if (begin == at_ - 1) return;
  while (at_ < begin) {
    const std::size_t before = at_;
    Value value = expression(depth + 1);
    if (is_word("as") && is_name(1)) {
      variables_[token(1).text] = std::move(value);
      at_ += 2;
    }
    if (is(",")) ++at_;
    if (at_ == before) ++at_;
  }
  at_ = begin;
  block(end, depth + 1);
}

// --- functions ---

/// A function that is called somewhere is read at each call; any other is read once, at its definition.
void PythonReader::define(int depth) {
  const std::size_t begin = body_begin(at_), end = body_end(at_, begin);
  if (begin == at_ || !is_name(1) || !is("(", 2)) {
    ++at_;
    return;
  }
  const std::string name = token(1).text;
  const Function function{at_ + 2, begin, end};
  if (source_ == &main_ && functions_.size() < 500) functions_[name] = function;
  if (!called_.contains(name)) {
    bind_parameters(function, {}, depth);
    results_.emplace_back();
    at_ = begin;
    block(end, depth + 1);
    results_.pop_back();
  }
  at_ = end;
}

namespace {
/// *args: a list of the arguments that no other parameter takes.
Value rest_of(const std::vector<Value>& values, std::size_t position) {
  Value out;
  out.kind = Value::Kind::list;
  for (std::size_t i = position; i < values.size() && out.weight + values[i].weight <= kHeaviest; ++i) {
    out.weight += values[i].weight;
    out.items.push_back(values[i]);
  }
  return out;
}
}  // namespace

/// Binds the arguments to the parameters; a missing one gets its default, or no value.
void PythonReader::bind_parameters(const Function& function, const Arguments& arguments, int depth) {
  const std::size_t end = std::min(main_.close[function.parameters], main_.tokens.size());
  std::size_t position = 0;
  for (at_ = function.parameters + 1; at_ < end;) {
    int stars = 0;
    for (; is("*"); ++at_) ++stars;
    if (!is_name()) {
      ++at_;
      continue;
    }
    const std::string name = token().text;
    ++at_;
    while (at_ < end && !is("=") && !is(",")) at_ = is("[") ? main_.close[at_] + 1 : at_ + 1;
    Value value;
    if (is("=")) {
      ++at_;
      value = expression(depth + 1);
    }
    if (stars == 1) value = rest_of(arguments.values, position);
    const Value* given = stars == 0 ? arguments.find(name) : nullptr;
    if (!given && stars == 0 && position < arguments.values.size()) given = &arguments.values[position];
    ++position;
    if (given) copied_ += given->weight;
    if (given && copied_ <= kMostCopied) value = *given;
    if (value.kind == Value::Kind::unknown && !given)
      variables_.erase(name);
    else
      variables_[name] = std::move(value);
    while (at_ < end && !is(",")) ++at_;
    ++at_;
  }
}

/// The return value of a function of the file for these arguments.
Value PythonReader::run(const Function& function, const Arguments& arguments, int depth) {
  if (calls_ >= kDeepestCall || !may_repeat(here())) return {};
  ++calls_;
  const PythonSource* const source = std::exchange(source_, &main_);
  const std::size_t at = at_;
  std::vector<std::string> names;
  for (std::size_t i = function.parameters; i < main_.close[function.parameters] && i < main_.tokens.size();
       ++i)
    if (main_.tokens[i].kind == PythonToken::Kind::name && names.size() < 50)
      names.push_back(main_.tokens[i].text);
  Value out;
  {
    const Bound bound(variables_, names);
    bind_parameters(function, arguments, depth);
    results_.emplace_back();
    at_ = function.body;
    block(function.end, depth + 1);
    out = std::move(results_.back());
    results_.pop_back();
  }
  source_ = source;
  at_ = at;
  --calls_;
  return out;
}

void PythonReader::returned() {
  const std::size_t end = source_->line_end[at_];
  ++at_;
  Value value;
  if (at_ < end) {
    value.kind = Value::Kind::list;
    while (at_ < end) {  // return a, b
      const std::size_t begin = at_;
      value.items.push_back(expression(0));
      if (is(",")) ++at_;
      if (at_ == begin) ++at_;
    }
    if (value.items.size() == 1) value = Value(std::move(value.items.front()));
  }
  if (!results_.empty() && results_.back().kind == Value::Kind::unknown && unsure_ == 0)
    results_.back() = std::move(value);
  at_ = std::max(at_, end);
}

// --- simple statements ---

void PythonReader::simple(std::size_t end) {
  if (is_word("return")) return returned();
  if (is_word("import") || is_word("from") || is_word("global")) {
    at_ = end;
    return;
  }
  if (!grown_list()) assignment(end);
  while (at_ < end) {
    const std::size_t begin = at_;
    if (is(";")) {
      ++at_;
      return;
    }
    if (is_name() || is("(") || is("[")) expression(0);
    if (at_ == begin) ++at_;
  }
}

/// NAME.append(VALUE), NAME.extend(LIST), NAME += LIST
bool PythonReader::grown_list() {
  if (!is_name()) return false;
  const auto found = variables_.find(token().text);
  if (found == variables_.end() || found->second.kind != Value::Kind::list) return false;
  const std::string name = token().text;
  const bool append = is(".", 1) && is_word("append", 2), extend = is(".", 1) && is_word("extend", 2);
  const bool added = is("+=", 1);
  if (!added && !((append || extend) && is("(", 3))) return false;
  Value more;
  if (added) {
    at_ += 2;
    more = expression(0);
  } else {
    at_ += 3;
    const Arguments arguments = called_with(1);
    more = arguments.values.empty() ? Value{} : arguments.values.front();
  }
  if (append) {
    Value list;
    list.kind = Value::Kind::list;
    list.weight = 1 + more.weight;
    list.items.push_back(std::move(more));
    more = std::move(list);
  }
  Value& list = variables_[name];
  const bool fits = more.kind == Value::Kind::list && list.kind == Value::Kind::list &&
                    list.weight + more.weight <= kHeaviest && unsure_ == 0;
  if (!fits) {
    list = {};  // it may have unknown items
  } else {
    list.weight += more.weight;
    for (Value& item : more.items) list.items.push_back(std::move(item));
  }
  return true;
}

/// A = B = VALUE, A, B = VALUES, A: TYPE = VALUE, A += VALUE, MAP["key"] = VALUE
bool PythonReader::assignment(std::size_t end) {
  std::vector<std::vector<std::string>> all;
  for (;;) {
    std::size_t i = at_;
    std::vector<std::string> names;
    const auto word = [&](std::size_t at) {
      return at < end && source_->tokens[at].kind == PythonToken::Kind::name &&
             !is_keyword(source_->tokens[at].text);
    };
    const auto sign = [&](std::size_t at, const char* text) {
      return at < end && source_->tokens[at].kind == PythonToken::Kind::sign &&
             source_->tokens[at].text == text;
    };
    while (word(i) && names.size() < 20) {
      names.push_back(source_->tokens[i++].text);
      if (!sign(i, ",")) break;
      ++i;
    }
    if (names.size() == 1 && all.empty() && sign(i, ":"))  // a type annotation
      while (i < end && !sign(i, "=")) ++i;
    if (names.size() == 1 && all.empty() && sign(i, "+=")) {
      at_ = i + 1;
      const Value more = expression(0);
      Value& value = variables_[names.front()];
      value = value.kind == Value::Kind::text && unsure_ == 0 ? Value::of(value.text + flat(more)) : Value{};
      return true;
    }
    const bool key = names.size() == 1 && all.empty() && sign(i, "[") && i + 3 < end &&
                     source_->tokens[i + 1].kind == PythonToken::Kind::string && sign(i + 2, "]") &&
                     sign(i + 3, "=");
    if (key) {
      const std::string entry = source_->tokens[i + 1].text;
      at_ = i + 4;
      Value inner = expression(0);
      const auto found = variables_.find(names.front());
      if (found == variables_.end() || found->second.kind != Value::Kind::map) return true;
      Value& map = found->second;
      std::erase_if(map.entries, [&](const auto& other) { return other.first == entry; });
      if (map.weight + inner.weight > kHeaviest) return true;
      map.weight += inner.weight;
      map.entries.emplace_back(entry, std::move(inner));
      return true;
    }
    if (names.empty() || !sign(i, "=")) break;
    all.push_back(std::move(names));
    at_ = i + 1;
    if (all.size() > 20) break;
  }
  if (all.empty()) return false;
  const std::size_t begin = at_;
  Value value = expression(0);
  if (is(",") && at_ < end) {  // a, b = c, d
    Value list;
    list.kind = Value::Kind::list;
    list.items.push_back(std::move(value));
    while (is(",") && at_ < end && list.items.size() < 50) {
      ++at_;
      list.items.push_back(expression(0));
    }
    for (const Value& item : list.items) list.weight += item.weight;
    value = list.weight > kHeaviest ? Value{} : std::move(list);
  }
  if (at_ == begin && at_ < end) ++at_;
  for (const auto& names : all) bind(names, value);
  return true;
}

}  // namespace polyarm::ros_files::python
