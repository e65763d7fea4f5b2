#include "polyarm/program/checker.hpp"

#include <algorithm>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/program/operators.hpp"

namespace polyarm::program {

using data::Kind;

Type type_of(const Value& value) {
  const data::Number* number = value.as_number();
  return {value.kind(), number ? std::optional(number->dimension) : std::nullopt};
}

void KnownNames::add(const data::DataSet& set) {
  for (const data::Entry& entry : set.entries()) names[entry.name] = type_of(entry.value);
}

void KnownNames::add(const data::DataStore& store) {
  for (const std::string& name : store.names()) names[name] = type_of(*store.find(name));
}

namespace {
using Statements = Statement::Kind;

const Type kBoolean{Kind::boolean, {}};
const Type kUnknown{};
Type number_of(std::optional<Dimension> dimension) {
  return {Kind::number, dimension};
}

bool is_place(Kind kind) {
  return kind == Kind::joints || kind == Kind::pose;
}

std::string described(const Type& type) {
  if (type.kind == Kind::number && type.dimension)
    return *type.dimension == Dimension::none ? "a number without unit" : name(*type.dimension);
  return type.kind ? data::name(*type.kind) : "something";
}

bool surely_other(const Type& a, const Type& b) {
  if (!a.kind || !b.kind) return false;
  if (is_place(*a.kind) && is_place(*b.kind)) return false;
  return *a.kind != *b.kind || (a.dimension && b.dimension && *a.dimension != *b.dimension);
}

bool is_comparison(Operator op) {
  return op >= Operator::equal && op <= Operator::greater_equal;
}

class Checker {
 public:
  Checker(const Program& program, const KnownNames& known, Problems& problems)
      : program_{program}, known_{known}, problems_{problems}, names_{known.names} {}

  void run() {
    collect_made(program_.statements);
    block(program_.statements);
    warn_of_case();
  }

 private:
  struct Scoped {
    std::string name;
    Type type;
  };

  void error(std::string code, Place place, std::string what, std::string advice = {}) {
    problems_.error(std::move(code), program_.at(place), std::move(what), std::move(advice));
  }
  void warning(std::string code, Place place, std::string what, std::string advice = {}) {
    problems_.warning(std::move(code), program_.at(place), std::move(what), std::move(advice));
  }

  /// Names that lines such as `set NAME True` will make.
  void collect_made(const Block& statements) {
    for (const Statement& s : statements) {
      if (s.kind == Statements::set_literal && !s.name.empty() && !known_.names.contains(s.name))
        made_.insert(s.name);
      collect_made(s.body);
      for (const Branch& branch : s.branches) collect_made(branch.body);
    }
  }

  std::vector<std::string> all_names() const {
    std::vector<std::string> out;
    for (const auto& name : names_) out.push_back(name.first);
    for (const Scoped& local : locals_) out.push_back(local.name);
    return out;
  }

  const Type* local(const std::string& name) const {
    const auto at =
        std::find_if(locals_.rbegin(), locals_.rend(), [&](const Scoped& l) { return l.name == name; });
    return at == locals_.rend() ? nullptr : &at->type;
  }

  Type type_of_name(const std::string& name, Place place) {
    used_.emplace(name, place);
    if (const Type* found = local(name)) return *found;
    if (const auto at = names_.find(name); at != names_.end()) return at->second;
    if (made_.contains(name)) return kUnknown;
    error("unknown-name", place, "there is nothing called '" + name + "'" + did_you_mean(name, all_names()),
          "names are data, points, tags and what `let` made");
    return kUnknown;
  }

  Type infer(const Expression& e) {
    using Kinds = Expression::Kind;
    switch (e.kind) {
      case Kinds::literal:
        return type_of(e.value);
      case Kinds::name:
        return type_of_name(e.name, e.place);
      case Kinds::unary:
        return infer_unary(e);
      case Kinds::binary:
        return infer_binary(e);
      case Kinds::call:
        return infer_call(e);
      default:
        break;
    }
    const std::vector<Type> parts = infer_all(e);
    if (e.kind == Kinds::list) return {Kind::list, {}};
    if (e.kind == Kinds::joined) return {Kind::text, {}};
    if (parts[0].kind && *parts[0].kind != Kind::list)
      error("bad-type", e.place, "only a list has elements, here is " + described(parts[0]));
    return kUnknown;
  }

  std::vector<Type> infer_all(const Expression& e) {
    std::vector<Type> out;
    for (const ExpressionPtr& part : e.parts) out.push_back(infer(*part));
    return out;
  }

  Type infer_unary(const Expression& e) {
    const Type of = infer(*e.parts[0]);
    const Kind wanted = e.op == Operator::logical_not ? Kind::boolean : Kind::number;
    if (of.kind && *of.kind != wanted)
      error(
          "bad-type", e.place,
          std::string("'") + spelling(e.op) + "' needs " + data::name(wanted) + ", here is " + described(of));
    return wanted == Kind::boolean ? kBoolean : number_of(of.dimension);
  }

  void refuse_pair(const Expression& e, const Type& a, const Type& b) {
    error("bad-type", e.place,
          std::string("'") + spelling(e.op) + "' cannot take " + described(a) + " and " + described(b));
  }

  Type infer_binary(const Expression& e) {
    const Type a = infer(*e.parts[0]), b = infer(*e.parts[1]);
    if (e.op == Operator::logical_and || e.op == Operator::logical_or) {
      if (surely_other(a, kBoolean) || surely_other(b, kBoolean)) refuse_pair(e, a, b);
      return kBoolean;
    }
    if (is_comparison(e.op)) {
      const bool ordered = e.op >= Operator::less && e.op <= Operator::greater_equal;
      if (surely_other(a, b) || (ordered && (!can_order(a) || !can_order(b)))) refuse_pair(e, a, b);
      return kBoolean;
    }
    return infer_arithmetic(e, a, b);
  }

  static bool can_order(const Type& type) {
    return !type.kind || *type.kind == Kind::number || *type.kind == Kind::text;
  }

  Type infer_arithmetic(const Expression& e, const Type& a, const Type& b) {
    if (!a.kind || !b.kind) return kUnknown;
    const bool joins =
        e.op == Operator::add && *a.kind == *b.kind && (*a.kind == Kind::text || *a.kind == Kind::list);
    if (joins) return a;
    if (*a.kind != Kind::number || *b.kind != Kind::number) {
      refuse_pair(e, a, b);
      return kUnknown;
    }
    if (!a.dimension || !b.dimension) return number_of({});
    return number_of(dimension_of(e, a, b));
  }

  std::optional<Dimension> dimension_of(const Expression& e, const Type& a, const Type& b) {
    std::optional<Dimension> out;
    if (e.op == Operator::multiply) {
      out = product(*a.dimension, *b.dimension);
    } else if (e.op == Operator::divide) {
      out = quotient(*a.dimension, *b.dimension);
    } else if (*a.dimension == *b.dimension) {
      out = a.dimension;
    }
    if (!out) refuse_pair(e, a, b);
    return out;
  }

  Type infer_call(const Expression& e) {
    const std::vector<Type> arguments = infer_all(e);
    const Function* function = find_function(e.name);
    if (!function) {
      error("unknown-function", e.place,
            "there is no function '" + e.name + "'" + did_you_mean(e.name, function_names()),
            "functions are " + join(function_names(), ", "));
      return kUnknown;
    }
    if (arguments.size() < function->least || arguments.size() > function->most) {
      error("bad-call", e.place,
            e.name + "() takes " + std::to_string(function->least) +
                (function->most > function->least ? " or more" : "") + " values, here are " +
                std::to_string(arguments.size()));
      return number_of({});
    }
    return number_of(e.name == "length" ? std::optional(Dimension::none) : arguments[0].dimension);
  }

  void condition(const Expression& e, const std::string& of) {
    const Type type = infer(e);
    if (type.kind && *type.kind != Kind::boolean)
      error("bad-type", e.place,
            "the condition of '" + of + "' is " + described(type) + ", True or False was expected");
  }

  void block(const Block& statements) {
    const std::size_t outer = locals_.size();
    bool left = false, said = false;
    for (const Statement& s : statements) {
      if (left && !said) warning("unreachable", s.place, "this line is never reached");
      said = said || left;
      statement(s);
      left = left || s.kind == Statements::stop || s.kind == Statements::break_loop ||
             s.kind == Statements::continue_loop;
    }
    locals_.resize(outer);
  }

  void statement(const Statement& s) {
    switch (s.kind) {
      case Statements::load:
      case Statements::import:
        return check_load(s);
      case Statements::set_literal:
        return check_set_literal(s);
      case Statements::set:
        return check_set(s);
      case Statements::let:
        return declare(s, s.expression ? infer(*s.expression) : kUnknown);
      case Statements::move:
        return check_move(s);
      case Statements::wait_time:
        return check_time(s.expression, true);
      case Statements::wait:
        return check_wait(s);
      case Statements::ask:
        return check_ask(s);
      case Statements::while_loop:
        if (s.expression) condition(*s.expression, "while");
        return block(s.body);
      case Statements::branch:
        return check_branches(s);
      case Statements::for_loop:
        return check_for(s);
      case Statements::log:
        for (const ExpressionPtr& argument : s.arguments) infer(*argument);
        return;
      case Statements::call:
        if (s.expression) infer(*s.expression);
        return;
      default:
        return;
    }
  }

  void check_load(const Statement& s) {
    if (!known_.folder || s.name.empty()) return;
    try {
      data::find_file(s.name, *known_.folder, program_.at(s.name_place));
    } catch (const Error& e) {
      problems_.add(e);
    }
  }

  void check_set_literal(const Statement& s) {
    if (s.name.empty()) return;
    used_.emplace(s.name, s.name_place);
    const Type now = type_of(s.literal);
    const Type* inner = local(s.name);
    const auto at = names_.find(s.name);
    if (!inner && at == names_.end()) {
      warning("new-name", s.name_place, "'" + s.name + "' is made here" + did_you_mean(s.name, all_names()),
              "give it a line in the data file if it is meant");
      names_[s.name] = now;
      return;
    }
    const Type before = inner ? *inner : at->second;
    if (s.literal.as_text() && names_.contains(*s.literal.as_text()))
      return warning("text-or-name", s.name_place,
                     "this sets '" + s.name + "' to the text \"" + *s.literal.as_text() + "\"",
                     "did you mean `set " + s.name + " = " + *s.literal.as_text() + "`?");
    if (before.kind && *before.kind != *now.kind)
      warning("new-type", s.name_place,
              "'" + s.name + "' was " + described(before) + " and becomes " + described(now), "");
  }

  void check_set(const Statement& s) {
    const Type value = s.expression ? infer(*s.expression) : kUnknown;
    if (s.name.empty()) return;
    used_.emplace(s.name, s.name_place);
    const Type* inner = local(s.name);
    const auto at = names_.find(s.name);
    if (!inner && at == names_.end()) {
      if (made_.contains(s.name)) return;
      return error("unknown-name", s.name_place,
                   "there is nothing called '" + s.name + "'" + did_you_mean(s.name, all_names()),
                   "write `let " + s.name + " = …` to make it");
    }
    const Type before = inner ? *inner : at->second;
    if (surely_other(before, value))
      error("bad-type", s.name_place,
            "'" + s.name + "' is " + described(before) + " and cannot become " + described(value),
            "a name keeps its type and unit");
  }

  void declare(const Statement& s, Type type) {
    if (s.name.empty()) return;
    if (local(s.name) || names_.contains(s.name))
      error("shadowing", s.name_place, "there is a '" + s.name + "' already",
            "choose another name, or change it with `set`");
    used_.emplace(s.name, s.name_place);
    locals_.push_back({s.name, type});
  }

  void check_move(const Statement& s) {
    if (!s.expression) return;
    const Type type = infer(*s.expression);
    if (!type.kind || is_place(*type.kind)) return;
    const Expression& point = *s.expression;
    const std::string what = point.kind == Expression::Kind::name ? "'" + point.name + "'" : "this";
    error("bad-type", point.place, what + " is " + described(type) + ", a point was expected",
          "moveto goes to a joint state or a pose");
  }

  void check_time(const ExpressionPtr& e, bool bare_seconds) {
    if (!e) return;
    const Type type = infer(*e);
    if (!type.kind) return;
    const bool bare = type.kind == Kind::number && type.dimension == Dimension::none;
    const bool fits = type.kind == Kind::number &&
                      (!type.dimension || *type.dimension == Dimension::time || (bare && bare_seconds));
    if (!fits)
      error("bad-type", e->place, "a time was expected, here is " + described(type),
            bare ? "say the unit, such as 2s" : "");
  }

  void check_wait(const Statement& s) {
    if (s.expression) {
      const Type type = infer(*s.expression);
      const bool may_be_time =
          type.kind == Kind::number && (!type.dimension || *type.dimension == Dimension::time);
      if (type.kind == Kind::number && type.dimension == Dimension::none) {
        error("bad-type", s.expression->place,
              "'wait' takes a condition or a time, here is a number without unit",
              "write `wait time 1` or `wait 1s`");
      } else if (type.kind && type.kind != Kind::boolean && !may_be_time) {
        error("bad-type", s.expression->place,
              "the condition of 'wait' is " + described(type) + ", True or False was expected");
      }
    }
    check_time(s.second, false);
    block(s.body);
  }

  void check_ask(const Statement& s) {
    if (s.expression) infer(*s.expression);
    if (s.second && (local(s.second->name) || names_.contains(s.second->name))) condition(*s.second, "wait");
  }

  void check_branches(const Statement& s) {
    for (const Branch& branch : s.branches) {
      if (branch.condition) condition(*branch.condition, "if");
      block(branch.body);
    }
  }

  void check_for(const Statement& s) {
    const Type first = s.expression ? infer(*s.expression) : kUnknown;
    const Type last = s.second ? infer(*s.second) : kUnknown;
    if (s.second && (surely_other(first, last) || surely_other(first, number_of({})) ||
                     surely_other(last, number_of({}))))
      error("bad-type", s.second->place, "a range goes from one number to another of the same unit");
    if (!s.second && s.expression && first.kind && *first.kind != Kind::list)
      error("bad-type", s.expression->place,
            "a list, or a range such as 1 .. 5, was expected, here is " + described(first));
    const std::size_t outer = locals_.size();
    declare(s, s.second ? first : kUnknown);
    block(s.body);
    locals_.resize(outer);
  }

  /// Names that a reader would take for one another.
  void warn_of_case() {
    std::map<std::string, std::set<std::string>> same;
    for (const auto& name : names_) same[lower(name.first)].insert(name.first);
    for (const auto& [name, place] : used_) {
      const auto& spellings = same[lower(name)];
      if (spellings.size() < 2 || *spellings.begin() == name) continue;
      warning("case", place, "'" + name + "' and '" + *spellings.begin() + "' differ only in case",
              "they are two names");
    }
  }

  const Program& program_;
  const KnownNames& known_;
  Problems& problems_;
  std::map<std::string, Type> names_;
  std::set<std::string> made_;
  std::map<std::string, Place> used_;
  std::vector<Scoped> locals_;
};
}  // namespace

void check(const Program& program, const KnownNames& known, Problems& problems) {
  Checker(program, known, problems).run();
}

}  // namespace polyarm::program
