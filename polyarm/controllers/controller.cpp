#include "polyarm/controllers/controller.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
std::size_t enter(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}
}  // namespace

const JointFacts* ControllerContext::find_joint(std::string_view whole_name) const {
  return joints.find(whole_name);
}

bool ControllerContext::has_state(std::string_view wanted) const {
  return state_names.find(wanted) != nullptr;
}
bool ControllerContext::has_command(std::string_view wanted) const {
  return command_names.find(wanted) != nullptr;
}

std::string ControllerContext::whole_name(const std::string& written) const {
  if (has_state(written) || has_command(written)) return written;
  const std::string with_robot = robot + "/" + written;
  if (has_state(with_robot) || has_command(with_robot)) return with_robot;
  // A name without its robot, where only one robot has it.
  const std::string ending = "/" + written;
  std::string found;
  for (const auto* names : {&state_names, &command_names})
    for (const std::string& known : *names)
      if (known.ends_with(ending) && known != found) {
        if (!found.empty()) return with_robot;
        found = known;
      }
  return found.empty() ? with_robot : found;
}

std::string ControllerContext::whole_joint(const std::string& written, const std::string& key) const {
  if (find_joint(written)) return written;
  if (find_joint(robot + "/" + written)) return robot + "/" + written;
  const JointFacts* only = nullptr;
  std::vector<std::string> known;
  for (const JointFacts& joint : joints) {
    known.push_back(joint.name.substr(joint.name.find('/') + 1));
    if (known.back() == written) only = only ? nullptr : &joint;
  }
  if (only) return only->name;
  const auto entry = parameters.entries.find(key);
  throw Error(Problem{"unknown-joint",
                      entry == parameters.entries.end() ? Location{} : entry->second.where,
                      "the controller '" + name + "' names the joint '" + written + "', which no robot has" +
                          did_you_mean(written, known),
                      {}});
}

std::uint64_t Controller::receive(const std::string& port, const Input&, bool) {
  throw Error("unknown-input", "this controller takes no messages called '" + port + "'");
}

Output* Controller::find_output(std::string_view wanted) const {
  for (const auto& output : outputs_)
    if (output->name() == wanted) return output.get();
  return nullptr;
}

void Controller::forget_interfaces() {
  for (auto* names : {&commands_, &states_, &references_, &exported_}) names->clear();
  outputs_.clear();
  chained_ = false;
}

std::size_t Controller::claim_command(const std::string& name) {
  return enter(commands_, name);
}
std::size_t Controller::claim_state(const std::string& name) {
  return enter(states_, name);
}
std::size_t Controller::export_reference(const std::string& name) {
  return enter(references_, name);
}
std::size_t Controller::export_state(const std::string& name) {
  return enter(exported_, name);
}

void Controller::read_command_timeout(Parameters& p) {
  command_watch_.timeout = 0;
  p.read("command_timeout", command_watch_.timeout,
         {.text = "timeout of commands, s; 0: none", .changeable = true, .least = 0});
}

Output& Controller::add_output(std::string name, std::string type, std::vector<std::string> fields) {
  return *outputs_.emplace_back(
      std::make_unique<Output>(std::move(name), std::move(type), std::move(fields)));
}

}  // namespace polyarm::controllers
