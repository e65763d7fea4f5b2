#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/ros_files/controller_entries.hpp"

namespace polyarm::ros_files {

namespace {
using Path = std::vector<std::string>;

/// Finds controllers, gains and rates in the parameters of ROS 1.
class Ros1Reader {
 public:
  Ros1Reader(const ParameterTree& tree, ControllersFile& out, Problems& problems)
      : tree_(tree), out_(out), problems_(problems) {}

  void read() { visit(tree_, {}); }

 private:
  void visit(const ParameterTree& node, const Path& path) {
    const std::string name = path.empty() ? "" : path.back();
    if (name == "joint_limits") return;
    if (name == "gazebo_ros_control" && node.find("pid_gains")) {
      for (auto& [key, entry] : node.find("pid_gains")->flat().entries) out_.pid_gains.entries[key] = entry;
      return;
    }
    if (is_controller(node, name)) return controller(node, path);
    if (node.value) leaf(node, path);
    if (node.value && node.value->list) return;  // maps in a list are not names
    for (const auto& [child, inner] : node.children) {
      Path next = path;
      next.push_back(child);
      visit(inner, next);
    }
  }

  static std::string type_of(const ParameterTree& node) {
    const ParameterTree* type = node.find("type");
    return type && type->value && type->value->values.size() == 1 ? type->value->values.front() : "";
  }

  bool is_controller(const ParameterTree& node, const std::string& name) const {
    if (name.empty()) return false;
    const std::string type = type_of(node);
    for (const char* action : {"FollowJointTrajectory", "GripperCommand", "ParallelGripperCommand"})
      if (type == action) return false;  // a planner's view of a controller
    if (type.find("Hardware") != std::string::npos || type.find("RobotHW") != std::string::npos ||
        type.find("Transmission") != std::string::npos)
      return false;
    if (is_class_name(type)) return true;
    if (!sounds_like_controller(name)) return false;
    if (node.find("type")) return true;
    for (const char* key : {"joint", "joints", "pid", "gains", "publish_rate", "left_wheel", "right_wheel"})
      if (const ParameterTree* child = node.find(key); child && (child->value || child->find("p")))
        return true;
    return false;
  }

  void controller(const ParameterTree& node, const Path& path) {
    const std::string type = type_of(node);
    const ParameterTree* written = node.find("type");
    if (!written)
      return problems_.warning("no-type", node.where,
                               "the controller '" + join_name(path) + "' has no type; it is left out",
                               "write 'type: PACKAGE/CLASS' below it, such as "
                               "effort_controllers/JointEffortController");
    if (!is_class_name(type))
      return problems_.warning(
          "bad-type", written->where,
          "'" + type + "' is not a type of controller; '" + join_name(path) + "' is left out",
          "write PACKAGE/CLASS, such as effort_controllers/JointEffortController");
    ControllerEntry entry;
    entry.name = path.back();
    entry.ns = join_name(Path(path.begin(), path.end() - 1));
    entry.type = type;
    entry.where = written->where;
    entry.parameters = node.flat("type");
    entry.ros1 = true;
    add_bounded(out_.controllers, std::move(entry));
  }

  void leaf(const ParameterTree& node, const Path& path) {
    if (path.back() != "loop_hz") {
      out_.unused.push_back({join_name(path), node.where, "no controller reads it"});
      return;
    }
    double rate = 0;
    ParameterReader(problems_).read("loop_hz", *node.value, rate);
    if (rate >= 1 && rate <= 10000)
      out_.update_rate = rate;
    else if (rate != 0)
      problems_.error("bad-value", node.where,
                      "'loop_hz: " + format_number(rate) + "' is not a rate of a cell",
                      "write a number from 1 to 10000");
  }

  const ParameterTree& tree_;
  ControllersFile& out_;
  Problems& problems_;
};
}  // namespace

void read_ros1_controllers(const ParameterTree& tree, ControllersFile& out, Problems& problems) {
  Ros1Reader(tree, out, problems).read();
}

}  // namespace polyarm::ros_files
