#pragma once
/// The control thread's data about controllers: order of updates, and prepared reactions to a failure of a
/// controller or component. Private to the room.
#include <algorithm>

#include "polyarm/control/controller_manager.hpp"

namespace polyarm::control {

/// A controller and everything that belongs to it.
struct ControllerManager::Slot {
  ~Slot() { runner.reset(); }  // its thread ends before the other members are destroyed

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
  std::vector<std::size_t> pushes;  // commands that keep moving a joint until they are withdrawn
  std::atomic<hardware::LifecycleState> state{hardware::LifecycleState::unconfigured};
  std::atomic<bool> chained{false};
  std::unique_ptr<realtime::PartHealth> part = std::make_unique<realtime::PartHealth>();

  // for an async controller: copies that it works on in parallel to the loop
  std::vector<double> own_states, own_commands;
  hardware::Cycle own_cycle;
  controllers::Verdict own_verdict;
  std::atomic<controllers::ReturnType> own_result{controllers::ReturnType::ok};
  std::atomic<bool> own_stop{false};
};

/// A prepared switch.
struct ControllerManager::Commit {
  std::vector<Slot*> stop, start;
  std::vector<std::pair<Slot*, bool>> chains;
  std::vector<std::string> start_interfaces, stop_interfaces;
  std::vector<std::size_t> left;  // velocities and efforts of stopped controllers without a successor
  Slot* refused = nullptr;        // the first controller whose activation failed
};

struct ControllerManager::Schedule {
  struct Entry {
    Slot* slot;
    controllers::Controller* controller;
    unsigned divisor;
    Nanoseconds period;            // 0: use the divisor
    std::unique_ptr<Commit> fall;  // executed when its update fails
    int home;                      // a component of its only group; -1: several groups, or none
  };
  std::vector<Entry> entries;
  std::vector<std::unique_ptr<Commit>> component_failures;
  std::vector<char> contained;  // by component: true if its faults affect its group only
};

}  // namespace polyarm::control
