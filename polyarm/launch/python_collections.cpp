/// Reads Python's lists, tuples, maps and comprehensions.
#include <algorithm>
#include <utility>

#include "polyarm/launch/python_reader.hpp"

namespace polyarm::ros_files::python {

namespace {

/// Adds the weight of an inner value. Returns false if the outer one would become too heavy.
bool add(Value& to, const Value& inner) {
  if (to.weight + inner.weight > kHeaviest) return false;
  to.weight += inner.weight;
  return true;
}

}  // namespace

Value PythonReader::sequence(const char* close, int depth) {
  Value out;
  out.kind = Value::Kind::list;
  if (const std::size_t loop = source_->loop[at_]; loop > at_ + 1 && depth < kDeepest) {
    const std::size_t item = at_ + 1, end = source_->close[at_];
    return comprehension(item, loop, end, depth);
  }
  ++at_;
  while (at_ < source_->tokens.size() && !is(close)) {
    const std::size_t begin = at_;
    const bool spread = is("*");
    if (spread) ++at_;
    Value item = expression(depth + 1);
    if (!is(",") && !is(close)) {  // something unsupported
      skip_element(depth + 1);
      item = {};
    }
    if (spread && item.kind == Value::Kind::list) {
      for (Value& inner : item.items)
        if (add(out, inner)) out.items.push_back(std::move(inner));
    } else if (add(out, item)) {
      out.items.push_back(std::move(item));
    }
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

/// [ITEM for NAMES in LIST if CONDITION …]: one ITEM per item of LIST; unknown if LIST is unknown.
Value PythonReader::comprehension(std::size_t item, std::size_t loop, std::size_t close, int depth) {
  Value out;
  out.kind = Value::Kind::list;
  comprehension(item, loop, close, depth, out);
  at_ = std::min(close + 1, source_->tokens.size());
  return out.kind == Value::Kind::list ? out : Value{};
}

void PythonReader::comprehension(std::size_t item, std::size_t loop, std::size_t close, int depth,
                                 Value& out) {
  at_ = loop + 1;
  const std::vector<std::string> names = targets("in");
  const Bound bound(variables_, names);
  const Value over = disjunction(depth + 1);
  const std::size_t after = at_;
  const bool is_known = over.kind == Value::Kind::list || over.kind == Value::Kind::map;
  std::vector<Value> all = is_known ? rounds(over, names.size()) : std::vector<Value>(1);
  const Unsure unsure(unsure_, !is_known);
  if (!is_known) out.kind = Value::Kind::unknown;
  if (all.size() > kMostRounds) left_out(here(), "only the first 200 rounds of a loop are read");
  all.resize(std::min<std::size_t>(all.size(), kMostRounds));
  for (const Value& value : all) {
    at_ = after;
    if (!may_repeat(here()) || depth > kDeepest) return;
    bind(names, value);
    Known wanted = Known::yes;
    while (is_word("if")) {
      ++at_;
      const Known next = known(disjunction(depth + 1));
      wanted = wanted == Known::no || next == Known::no ? Known::no : std::max(wanted, next);
    }
    if (wanted == Known::no) continue;
    const Unsure by_filter(unsure_, wanted == Known::open);
    if (wanted == Known::open) out.kind = Value::Kind::unknown;
    if (is_word("for") && at_ < close) {
      comprehension(item, at_, close, depth + 1, out);
      continue;
    }
    at_ = item;
    Value one = expression(depth + 1);
    if (add(out, one)) out.items.push_back(std::move(one));
  }
}

/// (x) is x; (x,) and (x, y) are lists.
Value PythonReader::parenthesised(int depth) {
  const std::size_t begin = at_;
  const bool generator = source_->loop[at_] > 0;
  Value list = sequence(")", depth);
  const bool tuple =
      generator || list.items.size() != 1 ||
      (at_ >= begin + 2 && at_ - 2 < source_->tokens.size() && source_->tokens[at_ - 2].text == ",");
  return tuple ? list : Value(std::move(list.items.front()));
}

Value PythonReader::map(int depth) {
  Value out;
  out.kind = Value::Kind::map;
  if (source_->loop[at_] > 0) {  // {… for … in …}
    at_ = std::min(source_->close[at_] + 1, source_->tokens.size());
    return {};
  }
  ++at_;
  while (at_ < source_->tokens.size() && !is("}")) {
    const std::size_t begin = at_;
    const bool spread = is("*") && is("*", 1);
    if (spread) at_ += 2;
    const Value key = disjunction(depth + 1);
    if (spread) {
      for (const auto& [name, value] : key.entries)
        if (add(out, value)) out.entries.emplace_back(name, value);
    }
    if (is(":")) {
      ++at_;
      Value value = expression(depth + 1);
      if (!is(",") && !is("}")) {
        skip_element(depth + 1);
        value = {};
      }
      if (add(out, value)) out.entries.emplace_back(flat(key), std::move(value));
    } else if (!is(",") && !is("}")) {
      skip_element(depth + 1);
    }
    if (is(",")) ++at_;
    if (at_ == begin) ++at_;
  }
  ++at_;
  return out;
}

}  // namespace polyarm::ros_files::python
