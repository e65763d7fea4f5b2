#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

namespace {
using Statements = Statement::Kind;

/// Checks names that belong to the cell: robots, tools, frames, and tags that only the hardware sets.
class CellNamesCheck {
 public:
  CellNamesCheck(const Program& program, const KnownNames& known, Scope& scope)
      : program_{program}, known_{known}, scope_{scope} {}

  void run() {
    bool tests = false;
    for_each_statement(program_.statements, [&](const Statement& s) {
      tests = tests || s.kind == Statements::test;
      own_names(s);
    });
    for_each_statement(program_.statements, [&](const Statement& s) {
      if (!tests) targets(s);
      if (known_.robots)
        for (const Clause& clause : s.clauses) meant(clause);
    });
  }

 private:
  /// Names that the program itself defines.
  void own_names(const Statement& s) {
    if (s.kind == Statements::let || s.kind == Statements::for_loop || s.kind == Statements::try_block)
      own_.insert({s.name, s.second_name});
    for (const Parameter& parameter : s.parameters) own_.insert(parameter.name);
  }

  /// A test plays the far side and may set every tag; a program must not set measured ones.
  void targets(const Statement& s) {
    if (s.kind == Statements::set || s.kind == Statements::set_literal || s.kind == Statements::pulse)
      not_measured(s.name, s.name_place);
    for (const Clause& clause : s.clauses)
      if (clause.kind == Clause::Kind::at) not_measured(clause.target, clause.place);
  }
  void not_measured(const std::string& name, Place place) {
    if (own_.contains(name)) return;
    if (const auto link = known_.brought.find(name); link != known_.brought.end())
      scope_.warning("read-only", place,
                     "'" + name + "' comes from the link '" + link->second +
                         "': what a program sets holds until the other side changes it",
                     "wait for it; if both sides set it, say direction: both in signals.yaml");
    if (!known_.measured.contains(name)) return;
    scope_.error("read-only", place,
                 "'" + name + "' is a measured value of the hardware; a program cannot set it",
                 "wait for it, or set the tag of the command that changes it");
  }

  void meant(const Clause& clause) {
    using Kinds = Clause::Kind;
    if (!clause.value) return;
    const Expression& e = *clause.value;
    const bool text = e.kind == Expression::Kind::literal && e.value.as_text();
    const std::string name = e.kind == Expression::Kind::name ? e.name : text ? *e.value.as_text() : "";
    if (name.empty() || own_.contains(name) || own_.contains(name.substr(0, name.find('.')))) return;
    if (clause.kind == Kinds::robot)
      one_of("robot", name, e.place, known_.robots->names, "write a robot of the cell");
    if (clause.kind == Kinds::tool && !is_point(name))
      one_of("tool", name, e.place, tools(),
             "a tool is a point of the data (the pose of its TCP in tool0), or the tool of a robot");
    if (clause.kind == Kinds::frame && !is_point(name))
      one_of(
          "frame", name, e.place, frames(),
          "a frame is a point of the data, a belt, 'world', 'base', or ROBOT/base, ROBOT/flange, ROBOT/tcp");
  }
  void one_of(const std::string& what, const std::string& name, Place place,
              const std::vector<std::string>& all, const std::string& advice) {
    if (std::find(all.begin(), all.end(), name) != all.end()) return;
    scope_.error("unknown-" + what, place,
                 "the cell has no " + what + " '" + name + "'" + did_you_mean(name, all),
                 what == "robot" ? "known are: " + join(all, ", ") : advice);
  }

  bool is_point(const std::string& name) const {
    const auto at = scope_.names.find(name);
    return at != scope_.names.end() && (!at->second.kind || *at->second.kind == data::Kind::pose);
  }
  std::vector<std::string> points() const {
    std::vector<std::string> out;
    for (const auto& [name, type] : scope_.names)
      if (is_point(name)) out.push_back(name);
    return out;
  }
  std::vector<std::string> tools() const {
    std::vector<std::string> out = points();
    out.insert(out.end(), known_.robots->tools.begin(), known_.robots->tools.end());
    out.insert(out.end(), {"tool0", "none"});
    return out;
  }
  std::vector<std::string> frames() const {
    std::vector<std::string> out = points();
    out.insert(out.end(), known_.robots->belts.begin(), known_.robots->belts.end());
    for (std::string& name : data::named_frames(known_.robots->names)) out.push_back(std::move(name));
    return out;
  }

  const Program& program_;
  const KnownNames& known_;
  Scope& scope_;
  std::set<std::string> own_;
};
}  // namespace

void check_cell_names(const Program& program, const KnownNames& known, Scope& scope) {
  CellNamesCheck(program, known, scope).run();
}

}  // namespace polyarm::program
