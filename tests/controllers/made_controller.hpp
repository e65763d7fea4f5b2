#pragma once
/// A controller made by the name of its type, on a rig.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "polyarm/plugins/types.hpp"
#include "tests/controllers/joint_rig.hpp"

namespace polyarm::controllers {

/// A controller by the name of its type, on one or two joints.
struct Made {
  controllers::Parameters implied;
  std::unique_ptr<Controller> controller;
  JointRig rig;
  explicit Made(const std::string& type, std::vector<std::string> joints = {"j1"})
      : controller(make_controller(type, implied)), rig(*controller, joints) {
    rig.context.parameters = implied;
  }
};

inline void change(Made& m, const std::string& key, const std::string& value) {
  const ParameterChange change = m.rig.context.parameters.change(key, value);
  ASSERT_EQ(m.controller->refuse_changes({change}), "");
  change.apply();
  m.controller->on_parameters_changed();
}

/// Position and velocity of each joint asked for and measured; an effort is commanded.
inline Made chainable(const std::vector<std::string>& joints = {"j1"}) {
  Made m("pid_controller/PidController", joints);
  m.rig.set("dof_names", joints);
  m.rig.set("command_interface", {"effort"});
  m.rig.set("reference_and_state_interfaces", {"position", "velocity"});
  for (const std::string& joint : joints) {
    m.rig.set("gains." + joint + ".p", {"10"});
    m.rig.set("gains." + joint + ".d", {"2"});
    m.rig.set("gains." + joint + ".feedforward_gain", {"0.5"});
  }
  return m;
}

inline Made from_outside() {
  Made m = chainable({"j1", "j2"});
  m.rig.set("use_external_measured_states", {"true"});
  return m;
}

}  // namespace polyarm::controllers
