#pragma once
/// What the control thread has of the controllers: who is updated in which order, and what is to be done when
/// one of them, or a component, fails. Private to the room.
#include <algorithm>

#include "polyarm/control/controller_manager.hpp"

namespace polyarm::control {

/// A controller and everything that belongs to it.
struct ControllerManager::Slot {
  int id = 0;
  std::string name;
  std::unique_ptr<controllers::Controller> controller;
  controllers::ControllerContext context;
  LoadOptions options;
  std::vector<std::size_t> commands, references, exported;  // indices in the table
  std::vector<std::size_t> pushes;  // of the commands, those that move a joint until they are taken back
  std::atomic<hardware::LifecycleState> state{hardware::LifecycleState::unconfigured};
  std::atomic<bool> chained{false};
  std::atomic<std::uint64_t> updates{0};

  // control thread
  bool active = false;
  realtime::PartHealth part;

  // of an async controller: what it works on while the loop goes on
  std::vector<double> own_states, own_commands;
  hardware::Cycle own_cycle;
  controllers::Verdict own_verdict;
  std::atomic<controllers::ReturnType> own_result{controllers::ReturnType::ok};
  std::atomic<bool> own_stop{false};
  std::unique_ptr<realtime::AsyncRunner> runner;  // last: its thread ends before the rest goes
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
    int home;                      // where a failure of it belongs, see Failure
  };
  std::vector<Entry> entries;
  std::vector<std::unique_ptr<Commit>> component_falls;
  std::vector<Failure> failures;  // of this cycle; there is room for all
  std::vector<char> ties;         // by component: what falls with it commands components outside its group
};

}  // namespace polyarm::control
