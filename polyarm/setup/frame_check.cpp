#include "polyarm/setup/frame_check.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::cell {

FrameCheck::FrameCheck(const std::vector<data::DataSet>& sets, const CellRobots& robots,
                       std::set<std::string> later)
    : robots_(robots), later_(std::move(later)) {
  for (const data::DataSet& set : sets)
    for (const data::Entry& entry : set.entries()) {
      entries_[entry.name] = &entry;
      if (const data::Point* point = entry.value.as_point()) origins_.insert(point->frame());
    }
}

/// `handler`: line of the `on error` around the statements; 0 if there is none.
void FrameCheck::note_uses(const program::Block& statements, int handler) {
  for (const program::Statement& s : statements) {
    program::for_each_expression(s, [&](const program::Expression& e) {
      for (const std::string& name : program::names_read(e)) {
        if (handler > 0)
          handled_.try_emplace(name, handler);
        else
          unhandled_.insert(name);
      }
    });
    note_uses(s.body, s.kind == program::Statement::Kind::try_block ? s.handler_place.line : handler);
    note_uses(s.handler, handler);
    for (const program::Branch& branch : s.branches) note_uses(branch.body, handler);
    for (const program::Clause& clause : s.clauses) note_uses(clause.otherwise, handler);
  }
}

int FrameCheck::handled_in(const std::string& name) const {
  const auto at = handled_.find(name);
  return at == handled_.end() || unhandled_.contains(name) ? 0 : at->second;
}

void FrameCheck::look_at(const program::Program& program) {
  note_uses(program.statements, 0);
  using Kind = program::Statement::Kind;
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == Kind::set || s.kind == Kind::set_literal) later_.insert(s.name.substr(0, s.name.find('.')));
    program::for_each_expression(s, [&](const program::Expression& e) {
      for (const program::Clause& clause : s.clauses) {
        if (&e != clause.value.get()) continue;
        const bool frame = clause.kind == program::Clause::Kind::frame;
        if (!frame && clause.kind != program::Clause::Kind::tool) continue;
        const bool named = e.kind == program::Expression::Kind::name;
        const bool text = e.kind == program::Expression::Kind::literal && e.value.as_text();
        const std::string name = named ? e.name : text ? *e.value.as_text() : std::string{};
        if (frame && name.empty()) calculated_ = true;
        if (frame && !name.empty()) stated_.insert(name);
        for (const std::string& read : program::names_read(e)) origins_.insert(read);
        if (!name.empty()) origins_.insert(name);
        return;
      }
      for (const std::string& name : program::names_read(e)) targets_.insert(name);
    });
  });
}

/// T_world_frame; empty if it is only known during the run. `of` names the frame; `own`: its name may not
/// occur in the chain, and may change in the run.
std::optional<Pose> FrameCheck::frame(const std::string& name, const data::Entry& of) const {
  data::FrameChain chain;
  try {
    chain = data::frame_chain(name, [&](const std::string& each) -> const data::Point* {
      const auto entry = entries_.find(each);
      const bool fixed = entry != entries_.end() && (!later_.contains(each) || each == of.name);
      return fixed ? entry->second->value.as_point() : nullptr;
    });
  } catch (const Error& e) {
    Problem problem = e.problems().front();
    problem.where = of.where;
    throw Error(problem);
  }
  if (chain.root.empty()) return chain.pose;
  if (later_.contains(chain.root)) return std::nullopt;
  std::vector<std::string> names;
  for (const auto& robot : robots_) names.push_back(robot->entry.name);
  std::vector<std::string> known = data::named_frames(names);
  if (const auto part = data::robot_frame(chain.root)) {
    if (part->robot.empty())
      return robots_.size() == 1 ? std::optional(robots_.front()->entry.base * chain.pose) : std::nullopt;
    for (const auto& robot : robots_)
      if (robot->entry.name == part->robot)
        return part->part == data::RobotFrame::Part::base ? std::optional(robot->entry.base * chain.pose)
                                                          : std::nullopt;
  }
  for (const auto& each : entries_)
    if (each.second->value.as_point()) known.push_back(each.first);
  const auto owner = entries_.find(chain.owner);
  const data::Entry& names_it = owner == entries_.end() ? of : *owner->second;
  throw Error(Problem{"unknown-frame", names_it.where,
                      "'" + names_it.name + "' is in the frame '" + chain.root + "', which does not exist" +
                          did_you_mean(chain.root, known),
                      data::kFramesAre});
}

std::optional<Pose> FrameCheck::in_world(const data::Entry& entry) const {
  return frame(entry.name, entry);
}

std::vector<Pose> FrameCheck::meanings(const data::Entry& entry) const {
  const auto own = in_world(entry);
  if (!own) return {};
  std::vector<Pose> out = {*own};
  // A point that names a frame is in that frame, whatever the frame of a move.
  if (!entry.value.as_point()->frame().empty() || !targets_.contains(entry.name)) return out;
  if (calculated_) return {};
  for (const std::string& name : stated_) {
    std::optional<Pose> at;
    try {
      at = frame(name, entry);
    } catch (const Error&) {  // reported at its own line
    }
    if (!at) return {};
    out.push_back(*at * *own);
  }
  return out;
}

bool FrameCheck::is_no_target(const std::string& name) const {
  return origins_.contains(name) && !targets_.contains(name);
}

}  // namespace polyarm::cell
