#pragma once
/// What the control thread has of the controllers: who is updated in which order, and what is to be done when
/// one of them, or a component, fails. Private to the room.
#include <algorithm>

#include "polyarm/control/controller_manager.hpp"

namespace polyarm::control {

/// A controller and everything that belongs to it.
struct ControllerManager::Slot {
  ~Slot() { runner.reset(); }  // its thread ends before the rest goes

  // control thread, every cycle
  std::unique_ptr<controllers::Controller> controller;
  std::unique_ptr<realtime::AsyncRunner> runner;
  Nanoseconds budget = 0;
  std::atomic<std::uint64_t> updates{0};
  int id = 0;
  bool active = false;

  std::string name;
  controllers::ControllerContext context;
  LoadOptions options;
  std::vector<std::size_t> commands, references, exported;  // indices in the table
  std::vector<std::size_t> pushes;  // of the commands, those that move a joint until they are taken back
  std::atomic<hardware::LifecycleState> state{hardware::LifecycleState::unconfigured};
  std::atomic<bool> chained{false};
  std::unique_ptr<realtime::PartHealth> part = std::make_unique<realtime::PartHealth>();

  // of an async controller: what it works on while the loop goes on
  std::vector<double> own_states, own_commands;
  hardware::Cycle own_cycle;
  controllers::Verdict own_verdict;
  std::atomic<controllers::ReturnType> own_result{controllers::ReturnType::ok};
  std::atomic<bool> own_stop{false};
};

/// A switch, prepared.
struct ControllerManager::Commit {
  std::vector<Slot*> stop, start;
  std::vector<std::pair<Slot*, bool>> chains;
  std::vector<std::string> start_interfaces, stop_interfaces;
  std::vector<std::size_t> left;  // velocities and efforts of those that stop, which nobody takes over
  Slot* refused = nullptr;        // the first whose activation failed
};

struct ControllerManager::Schedule {
  struct Entry {
    Slot* slot;
    controllers::Controller* controller;
    unsigned divisor;
    Nanoseconds period;            // 0: by the divisor
    std::unique_ptr<Commit> fall;  // when its update fails
    int home;  // a component of the only group that it works on; -1: of several, or of none
  };
  std::vector<Entry> entries;
  std::vector<std::unique_ptr<Commit>> component_falls;
  std::vector<char> contained;  // by component: a fault of it concerns its group alone
};

}  // namespace polyarm::control
