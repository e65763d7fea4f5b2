#include "polyarm/joint_control/forward_command_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
std::string last_part(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

/// "elbow.pid" of "elbow.pid.i", "gains.elbow" of "gains.elbow.p", "pid" of "pid"; "" where it is no gain.
std::string block_of_gains(const std::string& key) {
  const std::vector<std::string> words = split_words(key, ".");
  const auto word = std::find_if(words.begin(), words.end(),
                                 [](const std::string& w) { return w == "pid" || w == "gains"; });
  if (word == words.end()) return {};
  return word + 1 == words.end() ? key : key.substr(0, key.rfind('.'));
}

/// The trap that users of ros_control know: gains beside a controller that only hands numbers on.
void tell_gains(Parameters& p) {
  std::map<std::string, Location> blocks;  // where each begins
  for (auto entry = p.entries.begin(); entry != p.entries.end();) {
    const std::string block = block_of_gains(entry->first);
    if (block.empty()) {
      ++entry;
      continue;
    }
    const Location& where = entry->second.where;
    const auto [first, fresh] = blocks.try_emplace(block, where);
    if (!fresh && where.line < first->second.line) first->second = where;
    entry = p.entries.erase(entry);
  }
  for (const auto& [block, where] : blocks)
    p.problems().warning("no-effect", where,
                         "'" + block + "' has no effect: this controller forwards its commands unchanged",
                         "effort_controllers/JointPositionController and JointVelocityController have a PID");
}

std::vector<std::string> wanted_interfaces(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> joints, interfaces, names;
  std::string joint, interface = "";
  p.read("joints", joints, {"the joints, in the order of the values"});
  p.read("joint", joint, {"the joint, if there is only one"});
  p.read("interface_name", interface, {"the interface of each joint: position, velocity, effort, …"});
  p.read("interface_names", names, {"several interfaces of the one joint, in the order of the values"});
  p.read("interfaces", interfaces, {"whole interface names, in place of joints"});
  if (!joint.empty()) joints.push_back(joint);
  tell_gains(p);
  if (interface.empty() && names.empty() && !joints.empty()) interface = "position";
  if (!interface.empty()) names.push_back(interface);
  std::vector<std::string> out;
  for (const std::string& whole : interfaces) out.push_back(context.whole_name(whole));
  for (const std::string& one : joints)
    for (const std::string& kind : names) out.push_back(context.whole_name(one + "/" + kind));
  return out;
}

/// The joint that "arm/elbow" is, or that the reference "pid/elbow" or "pid/arm/elbow" of another controller
/// is about.
const JointFacts* joint_behind(const ControllerContext& context, const std::string& name) {
  if (const JointFacts* joint = context.find_joint(name)) return joint;
  const auto slash = name.find('/');
  if (slash == std::string::npos) return nullptr;
  const std::string inner = name.substr(slash + 1);
  const JointFacts* joint = context.find_joint(inner);
  return joint ? joint : context.find_joint(context.robot + "/" + inner);
}

Asked kind_of(const std::string& interface) {
  if (interface == "position") return Asked::position;
  if (interface == "velocity") return Asked::velocity;
  return interface == "acceleration" ? Asked::acceleration : Asked::effort;
}

bool is_of_joints(const std::string& interface) {
  return kind_of(interface) != Asked::effort || interface == "effort" || interface == "force" ||
         interface == "torque";
}
}  // namespace

CallbackReturn ForwardCommandController::on_configure(ControllerContext& context) {
  const std::vector<std::string> names = wanted_interfaces(context);
  read_command_timeout(context.parameters);
  context.parameters.read("keep_outputs", keep_outputs_,
                          {"what is no joint begins with what was sent last, at each activation"});
  for (const std::string& name : names) claim_command(name);
  position_of_.assign(names.size(), -1);
  stops_at_zero_.assign(names.size(), 0);
  pushes_.assign(names.size(), 0);
  outputs_.assign(names.size(), 0);
  kinds_.assign(names.size(), Asked::effort);
  asked_.reset(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string kind = last_part(names[i]);
    const JointFacts* facts = joint_behind(context, names[i].substr(0, names[i].rfind('/')));
    const bool joint = context.find_joint(names[i].substr(0, names[i].rfind('/'))) != nullptr;
    kinds_[i] = kind_of(kind);
    asked_.set(i, names[i], is_of_joints(kind) ? facts : nullptr);
    stops_at_zero_[i] = joint && (kind == "velocity" || kind == "acceleration");
    outputs_[i] = !facts;  // nor a reference that another controller follows with a joint
    pushes_[i] = joint && (kind == "effort" || kind == "force" || kind == "torque");
    if (joint && kind == "position" && context.has_state(names[i]))
      position_of_[i] = static_cast<int>(claim_state(names[i]));
  }
  const std::vector<double> nothing(names.size(), std::numeric_limits<double>::quiet_NaN());
  wanted_ = nothing;
  if (!keep_outputs_ || inbox_.value().size() != names.size()) inbox_.reset(nothing);
  if (names.empty()) refuse_no_joints(context.parameters);
  return names.empty() ? CallbackReturn::failure : CallbackReturn::success;
}

double ForwardCommandController::first_command(std::size_t i) noexcept {
  if (stops_at_zero_[i]) return 0;
  const double sent = std::isfinite(inbox_.value()[i]) ? inbox_.value()[i] : wanted_[i];
  if (keep_outputs_ && outputs_[i] && std::isfinite(sent)) return sent;
  if (std::isfinite(command(i))) return command(i);
  return position_of_[i] >= 0 ? state(static_cast<std::size_t>(position_of_[i])) : 0;
}

CallbackReturn ForwardCommandController::on_activate(const Cycle&) noexcept {
  inbox_.fetch();  // what was sent to joints while it was not active is forgotten
  command_watch().forget();
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    wanted_[i] = first_command(i);
    set_command(i, wanted_[i]);
  }
  return CallbackReturn::success;
}

bool ForwardCommandController::asks() const noexcept {
  for (std::size_t i = 0; i < wanted_.size(); ++i)
    if ((!stops_at_zero_[i] && !pushes_[i]) || wanted_[i] != 0) return true;
  return false;
}

/// What the last command asked for ends, as far as it is something that goes on by itself.
void ForwardCommandController::let_expire() noexcept {
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    if (stops_at_zero_[i] || pushes_[i]) wanted_[i] = 0;
    if (position_of_[i] >= 0) wanted_[i] = command(i);  // as limits have let it through
  }
}

ReturnType ForwardCommandController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  if (inbox_.fetch()) {
    command_watch().take(cycle.time, cycle.time);
    const std::vector<double>& sent = inbox_.value();
    for (std::size_t i = 0; i < wanted_.size(); ++i)
      if (std::isfinite(sent[i])) wanted_[i] = sent[i];
  }
  if (command_watch().expires(cycle.time, asks())) let_expire();
  const bool stop = verdict.speed <= 0;
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    if (position_of_[i] >= 0) asked_.note_position(i, state(static_cast<std::size_t>(position_of_[i])));
    if (stop && stops_at_zero_[i])
      wanted_[i] = 0;                            // a speed that was asked for before a stop does not return
    if (stop && position_of_[i] >= 0) continue;  // a position stays where it was commanded last
    set_command(i, wanted_[i]);
  }
  return ReturnType::ok;
}

std::vector<InputPort> ForwardCommandController::inputs() const {
  return {{"commands", {"std_msgs/Float64MultiArray"}}, {"command", {"std_msgs/Float64"}}};
}

std::uint64_t ForwardCommandController::receive(const std::string&, const Input& message, bool) {
  const auto* numbers = std::get_if<Numbers>(&message);
  if (!numbers) throw Error("wrong-message", "this controller takes numbers (std_msgs/Float64MultiArray)");
  if (numbers->values.size() != wanted_.size())
    throw Error("wrong-size",
                "the message has " + std::to_string(numbers->values.size()) +
                    " values, the controller commands " + std::to_string(wanted_.size()) + " interfaces",
                "in this order: " + join(command_interfaces(), ", "));
  Problems problems;
  for (std::size_t i = 0; i < kinds_.size(); ++i)
    if (const double value = numbers->values[i];
        !std::isfinite(value) || is_of_joints(last_part(command_interfaces()[i])))
      asked_.check(problems, i, kinds_[i], value);
  problems.throw_if_errors();
  send(numbers->values);
  return 0;
}

void ForwardCommandController::send(std::span<const double> values) noexcept {
  std::vector<double>& draft = inbox_.draft();
  if (values.size() != draft.size()) return;
  std::copy(values.begin(), values.end(), draft.begin());
  inbox_.publish();
}

}  // namespace polyarm::controllers
