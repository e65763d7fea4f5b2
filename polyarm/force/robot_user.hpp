#pragma once
#include <map>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::controllers {

/// A controller that needs the kinematics of its robot. Whoever makes controllers hands it the models of the
/// cell's robots, by name, before it is configured; they must outlive its configuration.
class RobotUser {
 public:
  using Models = std::map<std::string, const description::RobotModel*>;
  virtual ~RobotUser() = default;
  void set_models(Models models) { models_ = std::move(models); }

 protected:
  const Models& models() const { return models_; }

 private:
  Models models_;
};

}  // namespace polyarm::controllers
