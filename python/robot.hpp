#pragma once
/// A robot for Python: its description and the kinematics of its tool link. Arrays come in with the shapes
/// that polyarm/robot.py makes; they are checked here once more, since a wrong size would read foreign
/// memory. Any thread.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "python/bindings.hpp"

namespace polyarm::python {

class Robot {
 public:
  /// A catalogue name or a file; `tip` may be empty. Throws Error.
  Robot(const std::string& name, const std::string& tip, const std::map<std::string, std::string>& arguments);

  const kinematics::Chain& chain() const { return solver_.chain(); }
  std::size_t joints() const { return chain().joints(); }
  const description::RobotModel& model() const { return model_; }
  const ik::InverseKinematics& solver() const { return solver_; }
  std::vector<std::string> warnings() const;
  /// One value for each joint; NaN where the description states none.
  std::vector<double> limits(std::optional<double> description::JointLimits::*member) const;

  /// Rows of states to poses; to Jacobians.
  Numbers forward(const Numbers& q) const;
  Numbers jacobian(const Numbers& q, const std::string& frame) const;
  /// The nearest solution for each pose, NaN where there is none, and the outcomes. `seeds`: one for all, or
  /// one for each.
  py::tuple solve(const Numbers& poses, const Numbers& seeds) const;
  Numbers solve_all(const Numbers& pose, const Numbers& seed) const;
  /// The outcome and the reason, for a person.
  py::tuple explain(const Numbers& pose, const Numbers& seed) const;

  /// The number of states in an array with one row for each. Throws Error("wrong-size").
  std::size_t states_of(const Numbers& q) const;
  std::span<const double> only_state(const Numbers& q) const;
  /// Throws Error("wrong-size" | "bad-pose").
  static Pose only_target(const Numbers& pose);

 private:
  static std::vector<Pose> targets_of(const Numbers& poses);

  Problems warnings_;
  description::RobotModel model_;
  ik::InverseKinematics solver_;
};

}  // namespace polyarm::python
