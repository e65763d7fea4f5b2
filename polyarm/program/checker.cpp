#include "polyarm/program/checker.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>

#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/language/statement_parser.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/percent.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

using data::Kind;

Type type_of(const Value& value) {
  const data::Number* number = value.as_number();
  return {value.kind(), number ? std::optional(number->dimension) : std::nullopt};
}

void KnownNames::add(const data::DataSet& set) {
  for (const data::Entry& entry : set.entries()) {
    names[entry.name] = type_of(entry.value);
    if (entry.where.line > 0) defined[entry.name] = entry.where;
  }
}

void KnownNames::add(const data::DataStore& store) {
  for (const std::string& name : store.names()) {
    names[name] = type_of(*store.find(name));
    if (store.tag_role(name) == data::TagRole::state) measured.insert(name);
  }
}

bool takes_time(const Statement& s) {
  switch (s.kind) {
    case Statement::Kind::move:
    case Statement::Kind::wait:
    case Statement::Kind::wait_time:
    case Statement::Kind::ask:
    case Statement::Kind::load:
    case Statement::Kind::import:
    case Statement::Kind::meet:
    case Statement::Kind::lock:
    case Statement::Kind::together:
    case Statement::Kind::hold:
      return true;
    default:
      return false;
  }
}

namespace {
/// True if a line of `block` changes the variable.
bool sets_name(const Block& block, const std::string& name) {
  bool out = false;
  for_each_statement(block, [&](const Statement& s) {
    out = out || (s.kind == Statement::Kind::set && (s.name == name || s.name.starts_with(name + ".")));
  });
  return out;
}

using Statements = Statement::Kind;

class Checker {
 public:
  Checker(const Program& program, const KnownNames& known, Problems& problems)
      : program_{program}, known_{known}, problems_{problems}, scope_{program, known, problems} {}

  void run() {
    const bool understood = !problems_.has_errors();
    check_functions_names();
    block(program_.statements, true);
    for (const Statement& s : program_.statements) apart(s);
    check_tasks(program_, known_, scope_);
    check_cell_names(program_, known_, scope_);
    check_blends(program_, scope_);
    check_values(program_, scope_);
    if (understood) check_endless(program_, scope_);
    scope_.warn_of_case();
  }

 private:
  Type infer(const Expression& e) { return scope_.infer(e); }
  void error(std::string code, Place place, std::string what, std::string advice = {}) {
    scope_.error(std::move(code), place, std::move(what), std::move(advice));
  }
  void warning(std::string code, Place place, std::string what, std::string advice = {}) {
    scope_.warning(std::move(code), place, std::move(what), std::move(advice));
  }

  void check_functions_names() {
    std::map<std::string, Place> places;
    const Statement* stop = nullptr;
    for (const Statement& s : program_.statements) {
      if (s.kind == Statements::on_stop && stop)
        error("twice", s.place, "there is an 'on stop' already, " + scope_.in_line(stop->place, s.place),
              "a program has one");
      if (s.kind == Statements::on_stop && !stop) stop = &s;
      if (s.kind != Statements::function && s.kind != Statements::task) continue;
      const std::string what = s.kind == Statements::task ? "task" : "func";
      const auto [at, made] = places.try_emplace(what + " " + s.name, s.place);
      if (!made)
        error("twice", s.name_place,
              "there is a '" + at->first + "' already, " + scope_.in_line(at->second, s.place),
              "choose another name");
    }
  }

  /// Blocks outside of the program's own lines, with the names that those create.
  void apart(const Statement& s) {
    const std::size_t outer = scope_.variables.size();
    if (s.kind == Statements::function) {
      scope_.in_function = true;
      for (const Parameter& parameter : s.parameters) {
        const Type type = parameter.value ? infer(*parameter.value) : kUnknown;
        scope_.declare(parameter.name, parameter.place, type.kind && is_place(type) ? kUnknown : type);
      }
      block(s.body);
      scope_.in_function = false;
    }
    if (s.kind == Statements::task || s.kind == Statements::test) block(s.body);
    if (s.kind == Statements::trap) check_trap(s);
    if (s.kind == Statements::trap && has_tasks())
      warning("trap-outside", s.place, "this trap interrupts the lines outside of tasks alone",
              "put it into the task that it is to interrupt");
    if (s.kind == Statements::every) check_time(s.expression, false);
    if (s.kind == Statements::task) {
      scope_.forget(outer);
      for (const Statement& inner : s.body)
        if (inner.kind == Statements::trap) check_trap(inner);
    }
    if (s.kind == Statements::test) check_test(s);
    if (s.kind == Statements::when || s.kind == Statements::every || s.kind == Statements::on_stop) check_at_once(s);
    scope_.forget(outer);
  }

  /// A test is separate from the program that it runs.
  void check_test(const Statement& s) {
    for_each_statement(s.body, [&](const Statement& inner) {
      if (inner.kind == Statements::move)
        error("no-robot", inner.place, "a test moves no robot", "the program that it runs does");
    });
  }

  void check_at_once(const Statement& s) {
    const std::string what = s.kind == Statements::when    ? "when"
                             : s.kind == Statements::every ? "every"
                                                           : "on stop";
    if (s.kind == Statements::when && s.expression) condition(*s.expression, what);
    for_each_statement(s.body, [&](const Statement& inner) {
      if (takes_time(inner))
        error("waits", inner.place, "'" + what + "' runs within one cycle: nothing in it moves or waits",
              "set a tag here and let a task do it");
    });
    block(s.body);
  }

  bool has_tasks() const {
    return std::any_of(program_.statements.begin(), program_.statements.end(),
                       [](const Statement& s) { return s.kind == Statements::task; });
  }

  /// The block may move and wait, but not for its own task.
  void check_trap(const Statement& s) {
    const std::size_t outer = scope_.variables.size();
    if (s.expression) condition(*s.expression, "trap");
    for_each_statement(s.body, [&](const Statement& inner) {
      if (inner.kind == Statements::meet)
        error("deadlock", inner.place, "a trap cannot meet: the task that it interrupts would be missing",
              "set a tag here and let the task come to the meeting");
    });
    block(s.body);
    scope_.forget(outer);
  }

  void check_pulse(const Statement& s) {
    check_time(s.expression, false);
    if (s.name.empty()) return;
    if (!scope_.variable_in(s.name).empty())
      return error("bad-target", s.name_place, "a pulse is one of a tag, and '" + s.name + "' is a name of this program",
                   "name an output");
    scope_.used.emplace(s.name, s.name_place);
    check_target(s.name, s.name_place, kBoolean);
  }

  void condition(const Expression& e, const std::string& of) {
    const Type type = infer(e);
    if (type.kind && *type.kind != Kind::boolean)
      error("bad-type", e.place,
            "the condition of '" + of + "' is " + described(type) + ", True or False was expected");
  }

  static bool leaves(const Statement& s) {
    return s.kind == Statements::stop || s.kind == Statements::break_loop ||
           s.kind == Statements::continue_loop || s.kind == Statements::return_value ||
           s.kind == Statements::raise;
  }
  static bool is_separate(const Statement& s) {
    return s.kind == Statements::function || s.kind == Statements::task || s.kind == Statements::on_stop ||
           s.kind == Statements::test;
  }

  void block(const Block& statements, bool top = false) {
    const std::size_t outer = scope_.variables.size();
    bool left = false, said = false;
    for (const Statement& s : statements) {
      if (left && !said && !is_separate(s)) {
        warning("unreachable", s.place, "this line is never reached");
        said = true;
      }
      statement(s);
      left = left || leaves(s);
    }
    if (!top) scope_.forget(outer);
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
      case Statements::use:
        return check_clauses(s);
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
      case Statements::hold:
      case Statements::return_value:
        if (s.expression) infer(*s.expression);
        return;
      default:
        return structure(s);
    }
  }

  void structure(const Statement& s) {
    switch (s.kind) {
      case Statements::try_block: {
        block(s.body);
        const std::size_t outer = scope_.variables.size();
        scope_.declare(s.name, s.name_place, {Kind::record, {}});
        const bool kept = !s.name.empty() && !sets_name(s.handler, s.name);
        if (kept) scope_.errors.insert(s.name);
        block(s.handler);
        scope_.errors.erase(s.name);
        scope_.forget(outer);
        return;
      }
      case Statements::raise:
        return check_raise(s);
      case Statements::retry:
        if (s.expression && surely_other(infer(*s.expression), number_of(Dimension::none)))
          error("bad-type", s.expression->place, "'retry' takes how often, a number without unit");
        return;
      case Statements::together: {
        const std::size_t outside = fixed_;
        fixed_ = scope_.variables.size();
        block(s.body);
        fixed_ = outside;
        return;
      }
      case Statements::meet:
      case Statements::lock:
        check_time(s.second, false);
        return block(s.body);
      case Statements::pulse:
        return check_pulse(s);
      case Statements::expect:
        if (s.expression) condition(*s.expression, "expect");
        return check_time(s.second, false);
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
    scope_.used.emplace(s.name, s.name_place);
    const Type now = type_of(s.literal);
    const Type* inner = scope_.local(s.name);
    auto& names = scope_.names;
    const auto at = names.find(s.name);
    if (!inner && at == names.end()) {
      warning("new-name", s.name_place,
              "'" + s.name + "' is made here" + did_you_mean(s.name, scope_.all_names()),
              "add it to the data file if it is intended");
      names[s.name] = now;
      return;
    }
    const Type before = inner ? *inner : at->second;
    if (s.literal.as_text() && (names.contains(*s.literal.as_text()) || scope_.local(*s.literal.as_text())))
      return warning("text-or-name", s.name_place,
                     "this sets '" + s.name + "' to the text \"" + *s.literal.as_text() + "\"",
                     "did you mean `set " + s.name + " = " + *s.literal.as_text() + "`?");
    if (before.kind && *before.kind != *now.kind)
      warning("new-type", s.name_place,
              "'" + s.name + "' was " + described(before) + " and becomes " + described(now), "");
  }

  void check_set(const Statement& s) {
    const Type value = s.expression ? infer(*s.expression) : kUnknown;
    for (const PathPart& part : s.path)
      if (part.index && surely_other(infer(*part.index), number_of(Dimension::none)))
        error("bad-type", part.place, "the index of a list is a whole number", "write such as LIST[1]");
    if (s.name.empty()) return;
    scope_.used.emplace(s.name, s.name_place);
    check_target(s.name, s.name_place, s.path.empty() ? value : kUnknown);
  }

  /// A target of `set` for a value of type `value`.
  void check_target(const std::string& name, Place place, const Type& value) {
    const std::string variable = scope_.variable_in(name);
    const auto at = scope_.names.find(name);
    if (variable.empty() && at == scope_.names.end()) {
      if (scope_.made.contains(name) || program_.lacks_included) return;
      if (const std::string whole = name.substr(0, name.rfind('.'));
          whole != name && scope_.names.contains(whole) && scope_.variable_in(whole).empty())
        return error(
            "unknown-name", place, "'" + name + "' is a part of '" + whole + "', which is set as a whole",
            "write `set " + whole + " = " + whole + " with " + name.substr(whole.size() + 1) + " = …`");
      return error("unknown-name", place,
                   "there is nothing called '" + name + "'" + did_you_mean(name, scope_.all_names()),
                   "write `let " + name + " = …` to make it");
    }
    if (!variable.empty()) check_not_fixed(variable, place);
    const Type before = variable.empty() ? at->second : variable == name ? *scope_.local(name) : kUnknown;
    if (surely_other(before, value))
      error("bad-type", place,
            "'" + name + "' is " + described(before) + " and cannot become " + described(value),
            before.kind == Kind::number && before.dimension && value.kind == Kind::number
                ? "a name keeps its unit: " + unit_advice(*before.dimension)
            : before.kind == Kind::boolean && value.kind == Kind::number ? "write true or false"
                                                                         : "a name keeps its type and unit");
  }

  void check_not_fixed(const std::string& variable, Place place) {
    for (std::size_t i = 0; i < fixed_ && i < scope_.variables.size(); ++i)
      if (scope_.variables[i].name == variable)
        return error("fixed", place, "'" + variable + "' cannot be changed inside 'together'",
                     "its statements run at the same time; set a tag, or change it before or after");
  }

  void declare(const Statement& s, Type type) { scope_.declare(s.name, s.name_place, type); }

  void check_base_move(const Statement& s) {
    const bool turns = s.motion == Statement::Motion::turn;
    const Expression& amount = *s.arguments.front();
    const Type type = infer(amount);
    const Dimension wanted = turns ? Dimension::angle : Dimension::length;
    const bool to_pose = !turns && (!type.kind || *type.kind == Kind::pose);
    if (!to_pose && surely_other(type, number_of(wanted)))
      error("bad-type", amount.place,
            std::string("'") + (turns ? "turn" : "drive") + "' takes " +
                (turns ? "an angle" : "a length or a pose") + ", here is " + described(type),
            bare_number(amount) ? unit_advice(wanted, bare_number(amount))
            : turns             ? "write `turn 90deg`, to the left"
                                : "write `drive 500mm`, or `drive pose(2m, 1m, rz = 90deg)`");
    for (const Clause& clause : s.clauses) {
      const bool amounts = type.kind && *type.kind == Kind::number,
                 goes = type.kind && *type.kind == Kind::pose;
      if (clause.kind == Clause::Kind::frame && (turns || amounts))
        error("bad-clause", clause.place, "'frame' belongs to a drive to a pose",
              "a length and an angle count from where the base stands");
      if (clause.kind == Clause::Kind::duration && goes)
        error("bad-clause", clause.place, "'duration' belongs to a drive by a length or a turn",
              "state a speed: `speed 0.2m/s`");
    }
    check_clauses(s);
  }

  /// speedj, speedl.
  void check_speed_move(const Statement& s) {
    if (s.arguments.empty()) return check_clauses(s);  // the parser has reported the fault
    const Expression& velocities = *s.arguments.front();
    const Type type = infer(velocities);
    const std::string word = spelling(s.motion), advice = speed_move_advice(s.motion);
    if (type.kind && *type.kind != Kind::record)
      error("bad-type", velocities.place,
            "'" + word + "' takes a record of velocities, here is " + described(type), advice);
    const bool line = s.motion == Statement::Motion::speedl;
    for (std::size_t i = 0; velocities.kind == Expression::Kind::record && i < velocities.names.size(); ++i) {
      const std::string& name = velocities.names[i];
      const std::string_view axes[] = {"x", "y", "z", "rx", "ry", "rz"};
      if (line && std::find(std::begin(axes), std::end(axes), name) == std::end(axes)) {
        error("bad-type", velocities.parts[i]->place, "'" + name + "' is not one of x, y, z, rx, ry and rz",
              advice);
        continue;
      }
      const Type own = infer(*velocities.parts[i]);
      const data::Number* written = velocities.parts[i]->value.as_number();
      const bool zero = own.kind == Kind::number && own.dimension == Dimension::none &&
                        (velocities.parts[i]->kind != Expression::Kind::literal || written->value == 0);
      const bool turns = name.size() == 2 && name.front() == 'r';
      const bool speed = !surely_other(own, number_of(Dimension::speed)) && !(line && turns);
      const bool angular = !surely_other(own, number_of(Dimension::angular_speed)) && !(line && !turns);
      if (!zero && !speed && !angular)
        error("bad-type", velocities.parts[i]->place,
              "'" + name + "' is " + described(own) + ", " +
                  (line && !turns ? "a speed" : "an angular speed") + " was expected",
              advice);
    }
    check_clauses(s);
  }

  void check_move(const Statement& s) {
    if (s.moves_base()) return check_base_move(s);
    if (s.moves_at_speed()) return check_speed_move(s);
    const bool may_be_list = s.motion == Statement::Motion::movej || s.motion == Statement::Motion::movel;
    for (const ExpressionPtr& point : s.arguments) {
      const Type type = infer(*point);
      if (is_place(type) || (may_be_list && type.kind == Kind::list)) continue;
      const std::string what = point->kind == Expression::Kind::name ? "'" + point->name + "'" : "this";
      error("bad-type", point->place, what + " is " + described(type) + ", a point was expected",
            "a move goes to a joint state or a pose");
    }
    check_clauses(s);
  }

  void check_clauses(const Statement& s) {
    const Clause* blend = nullptr;
    const Clause* exact = nullptr;
    for (const Clause& clause : s.clauses) {
      if (clause.kind == Clause::Kind::blend) blend = &clause;
      if (clause.kind == Clause::Kind::exact) exact = &clause;
      check_clause(clause);
    }
    const bool single =
        s.kind == Statements::move && s.arguments.size() == 1 &&
        s.arguments.front()->kind == Expression::Kind::name &&
        is_place(scope_.local(s.arguments.front()->name) ? *scope_.local(s.arguments.front()->name)
                                                         : type_known(s.arguments.front()->name));
    if (blend && exact && single)
      warning("no-blend", blend->place, "this blend cannot happen: the move is exact",
              "leave one of the two");
  }

  Type type_known(const std::string& name) const {
    const auto at = scope_.names.find(name);
    return at == scope_.names.end() || !at->second.kind ? Type{Kind::list, {}} : at->second;
  }

  void check_clause(const Clause& clause) {
    using Kinds = Clause::Kind;
    using D = Dimension;
    switch (clause.kind) {
      case Kinds::speed:
        return check_quantity(clause, {D::speed, D::angular_speed, D::none}, "500mm/s, 30deg/s or 50%");
      case Kinds::accel:
        return check_quantity(clause, {D::acceleration, D::angular_acceleration, D::none},
                              "2m/s2, 200deg/s2 or 50%");
      case Kinds::payload:
        return check_quantity(clause, {D::mass}, "2kg");
      case Kinds::near: {
        const Type type = clause.value ? infer(*clause.value) : kUnknown;
        if (type.kind && *type.kind != Kind::joints)
          error("bad-type", clause.value->place, "'near' takes a joint state, here is " + described(type),
                "");
        return;
      }
      case Kinds::around: {
        const Type type = clause.value ? infer(*clause.value) : kUnknown;
        if (type.kind && *type.kind != Kind::boolean)
          error("bad-type", clause.value->place, "'around' takes true or false, here is " + described(type),
                "write `around true`");
        return;
      }
      case Kinds::blend:
        return check_quantity(clause, {D::length}, "20mm");
      case Kinds::duration:
        return check_quantity(clause, {D::time}, "2s");
      case Kinds::until:
        if (clause.value) condition(*clause.value, "until");
        return block(clause.otherwise);
      case Kinds::at:
        return check_at(clause);
      case Kinds::robot:
      case Kinds::tool:
      case Kinds::frame:
        if (clause.value && clause.value->kind != Expression::Kind::name) infer(*clause.value);
        return;
      default:
        return;
    }
  }

  void check_quantity(const Clause& clause, std::initializer_list<Dimension> dimensions,
                      const char* such_as) {
    if (!clause.value) return;
    const Type type = infer(*clause.value);
    const auto fits = [&](Dimension dimension) { return type.dimension == dimension; };
    if (!type.kind || (type.kind == Kind::number && !type.dimension)) return;
    const std::string word = std::string("'") + spelling(clause.kind) + "'";
    if (type.kind != Kind::number || std::none_of(dimensions.begin(), dimensions.end(), fits))
      return error("bad-type", clause.value->place, word + " cannot be " + described(type),
                   dimensions.size() == 1 ? unit_advice(*dimensions.begin(), bare_number(*clause.value))
                                          : std::string("write such as ") + such_as);
    const data::Number* value =
        clause.value->kind == Expression::Kind::literal ? clause.value->value.as_number() : nullptr;
    if (value && value->dimension == Dimension::none && value->value > 1)
      error("bad-value", clause.value->place,
            word + " as a percentage is at most 100%, here it is " + percent(value->value),
            std::string("with a unit write such as ") + such_as);
  }

  void check_at(const Clause& clause) {
    if (clause.value) {
      const Type type = infer(*clause.value);
      if (surely_other(type, number_of(Dimension::length)) && surely_other(type, number_of(Dimension::time)))
        error("bad-type", clause.value->place, "'at' takes a length or a time, here is " + described(type),
              "write such as `at end - 20mm` or `at start + 1s`");
    }
    const Type value = clause.to ? infer(*clause.to) : kUnknown;
    if (clause.target.empty()) return;
    if (!scope_.variable_in(clause.target).empty())
      return error("bad-target", clause.place,
                   "an `at` clause sets tags and data, but '" + clause.target + "' is a name of this program",
                   "");
    check_target(clause.target, clause.place, value);
  }

  void check_raise(const Statement& s) {
    if (!s.expression) return;
    const Type type = infer(*s.expression);
    if (type.kind && type.kind != Kind::text && type.kind != Kind::record)
      error("bad-type", s.expression->place, "'raise' takes a text or an error, here is " + described(type));
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
            unit_advice(Dimension::time, bare_number(*e)));
  }

  static std::string wait_number(const Expression& e) {
    return bare_number(e) ? e.value.text() : std::string("1");
  }

  void check_wait(const Statement& s) {
    if (s.expression) {
      const Type type = infer(*s.expression);
      const bool may_be_time =
          type.kind == Kind::number && (!type.dimension || *type.dimension == Dimension::time);
      if (type.kind == Kind::number && type.dimension == Dimension::none) {
        error("bad-type", s.expression->place,
              "'wait' takes a condition or a time, here is a number without unit",
              bare_number(*s.expression)
                  ? "write `wait time " + wait_number(*s.expression) + "` or `wait " +
                        wait_number(*s.expression) + "s`"
                  : "write `wait 1s`, or `wait " + spelled(*s.expression) + " > 0` for a condition");
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
    if (s.second && (scope_.local(s.second->name) || scope_.names.contains(s.second->name)))
      condition(*s.second, "wait");
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
      error("bad-type", s.second->place,
            "a range goes from one number to another of the same unit, here are " + described(first) +
                " and " + described(last),
            "write such as 1 .. 5");
    if (!s.second && s.expression && first.kind && *first.kind != Kind::list)
      error("bad-type", s.expression->place,
            "a list, or a range such as 1 .. 5, was expected, here is " + described(first));
    const std::size_t outer = scope_.variables.size();
    if (!s.second_name.empty()) scope_.declare(s.second_name, s.place, number_of(Dimension::none));
    declare(s, s.second ? first : kUnknown);
    block(s.body);
    scope_.forget(outer);
  }

  const Program& program_;
  const KnownNames& known_;
  Problems& problems_;
  Scope scope_;
  std::size_t fixed_ = 0;  ///< number of variables that must not be changed here
};
}  // namespace

void check(const Program& program, const KnownNames& known, Problems& problems) {
  Checker(program, known, problems).run();
}

}  // namespace polyarm::program
