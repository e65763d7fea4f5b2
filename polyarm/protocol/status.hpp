#pragma once
/// Events with which the pendant's port reports the state of a cell and of jogs.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/protocol/session.hpp"

namespace polyarm::protocol {

/// m; rounded to 0.1 mm and about 0.1 deg.
struct BasePose {
  Vec3 p;
  Quaternion q;
  POLYARM_MEMBERS(BasePose, p, q)
};

struct CellStatus {
  std::string event = "status", cell, state, cause, cause_code;
  FactValues cause_facts;  ///< the variable parts of `cause`
  std::string held;        ///< why it does not run; empty: it runs
  PossibleNow can;
  ContactState contacts;
  bool standing = false, motion_left = false, armed = false, needs_arming = false, simulated = false;
  std::string profile;
  bool reduced = false;
  double override_ = 100, allowed = 100;
  std::string control;              ///< "program", "jog" or "nobody"
  std::vector<std::string> jogged;  ///< robots that are being jogged
  OrNull<ProgramOverview> program, plc;
  OrNull<std::string> failure;
  std::uint64_t alarms = 0;  ///< number of the newest alarm
  std::vector<std::string>
      inactive;  ///< hardware that is not active, and inactive controllers that could move a robot
  std::map<std::string, BasePose> bases;
  OrNull<ClientName> holder, asker;  ///< clients that have control or ask for it
  std::uint64_t clients = 0;
  POLYARM_MEMBERS(CellStatus, event, cell, state, cause, cause_code, cause_facts, held, can, contacts,
                  standing, motion_left, armed, needs_arming, simulated, profile, reduced, override_, allowed,
                  control, jogged, program, plc, failure, alarms, inactive, bases, holder, asker, clients)
};

/// The status while no cell runs.
struct NoCellStatus {
  std::string event = "status", state = "no cell";
  OrNull<std::string> cell;
  OrNull<ClientName> holder, asker;
  std::uint64_t clients = 0;
  POLYARM_MEMBERS(NoCellStatus, event, state, cell, holder, asker, clients)
};

/// State of a motion started by jog.begin or jog.goto: what limits it now, or why it has ended.
struct JogEvent {
  std::string event = "jog";
  std::uint64_t jog = 0;
  std::string robot;
  bool over = false;
  std::string why, text;
  std::string which;  ///< the joint or the workspace zone that limits it; empty: neither
  POLYARM_MEMBERS(JogEvent, event, jog, robot, over, why, text, which)
};

}  // namespace polyarm::protocol
