#include "polyarm/controllers/forward_command_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
std::string last_part(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

std::vector<std::string> wanted_interfaces(const Parameters& p) {
  std::vector<std::string> out = p.list("interfaces");
  for (const std::string& joint : p.list("joints"))
    out.push_back(joint + "/" + p.text("interface_name", "position"));
  if (p.has("joint"))
    for (const std::string& interface : p.list("interface_names"))
      out.push_back(p.text("joint") + "/" + interface);
  return out;
}
}  // namespace

CallbackReturn ForwardCommandController::on_configure(const ControllerContext& context) {
  names_.clear();
  position_states_.clear();
  for (const std::string& name : wanted_interfaces(context.parameters)) {
    const bool whole = std::count(name.begin(), name.end(), '/') >= 2;
    names_.push_back(whole ? name : context.robot + "/" + name);
  }
  position_of_.assign(names_.size(), -1);
  stops_at_zero_.assign(names_.size(), false);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::string kind = last_part(names_[i]);
    const bool joint = context.find_joint(names_[i].substr(0, names_[i].rfind('/'))) != nullptr;
    stops_at_zero_[i] = joint && (kind == "velocity" || kind == "acceleration");
    if (joint && kind == "position") {
      position_of_[i] = static_cast<int>(position_states_.size());
      position_states_.push_back(names_[i]);
    }
  }
  const std::vector<double> nothing(names_.size(), std::numeric_limits<double>::quiet_NaN());
  wanted_ = nothing;
  inbox_.reset(nothing);
  return names_.empty() ? CallbackReturn::failure : CallbackReturn::success;
}

CallbackReturn ForwardCommandController::on_activate(const Cycle&) noexcept {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    double start = command(i);
    if (!std::isfinite(start))
      start = position_of_[i] >= 0 ? state(static_cast<std::size_t>(position_of_[i])) : 0;
    wanted_[i] = start;
    set_command(i, start);
  }
  return CallbackReturn::success;
}

ReturnType ForwardCommandController::update(const Cycle&, const Verdict& verdict) noexcept {
  if (inbox_.fetch()) {
    const std::vector<double>& sent = inbox_.value();
    for (std::size_t i = 0; i < wanted_.size(); ++i)
      if (std::isfinite(sent[i])) wanted_[i] = sent[i];
  }
  const bool stop = verdict.speed <= 0;
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    if (stop && position_of_[i] >= 0) continue;  // a position stays where it was commanded last
    set_command(i, stop && stops_at_zero_[i] ? 0.0 : wanted_[i]);
  }
  return ReturnType::ok;
}

void ForwardCommandController::send(std::span<const double> values) noexcept {
  std::vector<double>& draft = inbox_.draft();
  if (values.size() != draft.size()) return;
  std::copy(values.begin(), values.end(), draft.begin());
  inbox_.publish();
}

}  // namespace polyarm::controllers
