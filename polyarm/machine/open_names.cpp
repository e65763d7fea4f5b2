#include "polyarm/machine/open_names.hpp"

#include <algorithm>

#include "polyarm/machine/cell_data.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace {
void add_signals(const signals::Signals& signals, std::set<std::string>& out) {
  for (const signals::Tag& tag : signals.tags)
    if (tag.role == data::TagRole::state) out.insert(tag.name);
  for (const signals::CameraLink& camera : signals.cameras)
    out.insert({camera.point, camera.request, camera.done});
  for (const signals::LinkEntry& link : signals.links)
    for (const signals::LinkTag& tag : link.tags)
      if (tag.direction != signals::Direction::out) out.insert(tag.name);
  if (signals.heartbeat) out.insert(signals.heartbeat->tag);
}

/// Adds points whose frame is in `out`, or on a robot.
void add_points(const data::DataStore& store, std::set<std::string>& out) {
  const auto on_robot = [&](const std::string& frame) {
    return frame.find('/') != std::string::npos && !frame.ends_with("/base");
  };
  const std::vector<std::string> names = store.names();
  for (bool more = true; more;) {
    more = false;
    for (const std::string& name : names) {
      const data::Point* point = store.find(name)->as_point();
      if (!point || point->frame().empty() || out.contains(name)) continue;
      if (out.contains(point->frame()) || on_robot(point->frame())) more = out.insert(name).second;
    }
  }
}
}  // namespace

std::set<std::string> names_set(const program::Program& program) {
  using Kind = program::Statement::Kind;
  std::set<std::string> out;
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == Kind::set || s.kind == Kind::set_literal) out.insert(s.name);
    for (const program::Clause& clause : s.clauses)
      if (!clause.target.empty()) out.insert(clause.target);
  });
  return out;
}

std::set<std::string> open_names(const CellData& data, const program::Program* others) {
  std::set<std::string> out;
  add_signals(data.signals(), out);
  for (const std::string& name : data.store.names())
    if (const std::string set = data.store.set_of(name); !set.empty() && data.files().is_live(set))
      out.insert(name);
  if (others) out.merge(names_set(*others));
  add_points(data.store, out);
  return out;
}

}  // namespace polyarm::cell
