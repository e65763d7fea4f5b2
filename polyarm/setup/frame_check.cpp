#include "polyarm/setup/frame_check.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"
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

std::optional<Pose> FrameCheck::frame(const std::string& name, const data::Entry& of,
                                      std::vector<std::string>& way) const {
  if (name.empty() || name == "world") return Pose{};
  if (later_.contains(name)) return std::nullopt;
  if (const auto at = std::find(way.begin(), way.end(), name); at != way.end()) {
    std::vector<std::string> circle(at, way.end());
    circle.push_back(name);
    throw Error(Problem{"frame-cycle", of.where,
                        circle.size() == 2
                            ? "the frame '" + name + "' is stated in itself"
                            : "frames depend on each other in a circle: " + join(circle, " in "),
                        "one frame of the chain must be in the world, or on a robot"});
  }
  way.push_back(name);
  const auto entry = entries_.find(name);
  const data::Point* const point = entry == entries_.end() ? nullptr : entry->second->value.as_point();
  if (point) {
    const auto outer = frame(point->frame(), *entry->second, way);
    return outer ? std::optional(*outer * point->pose) : std::nullopt;
  }
  if (name == "base") return robots_.size() == 1 ? std::optional(robots_.front()->entry.base) : std::nullopt;
  std::vector<std::string> known = {"world", "base"};
  for (const auto& robot : robots_) {
    for (const char* part : {"base", "flange", "tool0", "tcp"})
      if (known.push_back(robot->entry.name + "/" + part); name == known.back())
        return part == std::string_view("base") ? std::optional(robot->entry.base) : std::nullopt;
  }
  for (const auto& each : entries_)
    if (each.second->value.as_point()) known.push_back(each.first);
  throw Error(Problem{
      "unknown-frame", of.where,
      "'" + of.name + "' is in the frame '" + name + "', which does not exist" + did_you_mean(name, known),
      "a frame is a point of the data, 'world', 'base', or ROBOT/base, ROBOT/flange, ROBOT/tcp"});
}

std::optional<Pose> FrameCheck::in_world(const data::Entry& entry) const {
  const data::Point& point = *entry.value.as_point();
  std::vector<std::string> way = {entry.name};
  const auto outer = frame(point.frame(), entry, way);
  return outer ? std::optional(*outer * point.pose) : std::nullopt;
}

std::vector<Pose> FrameCheck::meanings(const data::Entry& entry) const {
  const auto own = in_world(entry);
  if (!own) return {};
  std::vector<Pose> out = {*own};
  // A point that names a frame is in that frame, whatever the frame of a move.
  if (!entry.value.as_point()->frame().empty() || !targets_.contains(entry.name)) return out;
  if (calculated_) return {};
  for (const std::string& name : stated_) {
    std::vector<std::string> way;
    std::optional<Pose> at;
    try {
      at = frame(name, entry, way);
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
