/// Maps a ROS 2 action to goals of a controller.
#include <cmath>
#include <utility>

#include "polyarm/protocol/messages.hpp"
#include "polyarm/ros2/goal_server.hpp"

namespace polyarm::ros2 {

namespace {

constexpr Nanoseconds kReportAgain = 5'000'000'000;
/// Value of error_code in control_msgs/FollowJointTrajectory.
constexpr int kInvalidGoal = -1;

/// Converts a feedback message of the cell into that of the action type.
Json feedback_of(const std::string& type, Json sample) {
  if (!type.ends_with("FollowJointTrajectory")) return sample;
  Json out{{"header", sample["header"]}, {"joint_names", sample["joint_names"]}};
  const std::pair<const char*, const char*> names[] = {
      {"desired", "reference"}, {"actual", "feedback"}, {"error", "error"}};
  for (const auto& [theirs, ours] : names) out[theirs] = sample[ours];
  return out;
}

using GoalAnswer = protocol::SendMessage::Answer;

/// `ended`: the last answer of the cell.
Json result_of(const std::string& type, const GoalAnswer& ended, const std::string& why = {}) {
  if (type.ends_with("FollowJointTrajectory")) {
    std::string text = ended.error.value_or("");
    if (!why.empty()) text += (text.empty() ? "" : ": ") + why;
    if (ended.note)
      text += ": " + *ended.note;
    else if (ended.joint && ended.off_by && std::isfinite(*ended.off_by))
      text += ": " + *ended.joint + " is off by " + protocol::Any(*ended.off_by).dump() + ", allowed " +
              protocol::Any(ended.tolerance.value_or(NAN)).dump();
    return {{"error_code", ended.error_code.value_or(0)}, {"error_string", text}};
  }
  Json out{{"stalled", ended.stalled.value_or(false)}, {"reached_goal", ended.reached_goal.value_or(false)}};
  const double position = ended.position.value_or(0), effort = ended.effort.value_or(0);
  if (type.ends_with("ParallelGripperCommand"))
    out["state"] = {{"position", Json::array({position})}, {"effort", Json::array({effort})}};
  else
    out["position"] = position, out["effort"] = effort;
  return out;
}

/// May outlive the ActionServer while the cell still has replies to send.
class Server : public std::enable_shared_from_this<Server> {
 public:
  Server(Bridge& bridge, ActionPort port)
      : bridge_{bridge},
        port_{std::move(port)},
        goals_{std::make_shared<GoalServer>(bridge, port_.node, port_.name, port_.type)} {}

  void begin() {
    const std::weak_ptr<Server> self = weak_from_this();
    goals_->begin({[self](const GoalPointer& goal, Json message, Reply reply) {
                     if (const auto server = self.lock()) server->take(goal, std::move(message), reply);
                   },
                   [self](const GoalPointer& goal) {
                     if (const auto server = self.lock()) server->cancel(*goal);
                   }});
  }

  void serve() { goals_->serve(); }
  void close() {
    closed_ = true;
    goals_->close();
  }

 private:
  std::string target() const { return port_.controller + "/" + port_.port; }

  void take(const GoalPointer& goal, Json message, const Reply& reply) {
    if (message.contains("trajectory")) bridge_.to_cell(message["trajectory"]);
    for (const char* list :
         {"path_tolerance", "goal_tolerance", "component_path_tolerance", "component_goal_tolerance"})
      if (message.contains(list) && message[list].empty()) message.erase(list);
    if (message.contains("multi_dof_trajectory") && message["multi_dof_trajectory"]["points"].empty())
      message.erase("multi_dof_trajectory");
    // In ROS 2, a goal time tolerance of 0 means that none is given.
    if (message.contains("goal_time_tolerance") && nanoseconds_of(message["goal_time_tolerance"]) == 0)
      message.erase("goal_time_tolerance");
    const auto self = shared_from_this();
    ++asking_;
    protocol::SendMessage sent;
    sent.to = target();
    sent.message = protocol::Message(std::move(message));
    sent.goal = true;
    bridge_.ask(std::move(sent), [self, goal, reply](const protocol::Reply& replied) {
      if (goal->status == GoalStatus::STATUS_UNKNOWN) --self->asking_;
      if (!self->closed_) self->answered(goal, replied, reply);
    });
  }

  void cancel(const Goal& goal) {
    bridge_.ask(protocol::GoalCancel{target(), static_cast<double>(goal.number)},
                [](const protocol::Reply&) {});
  }

  void answered(const GoalPointer& goal, const protocol::Reply& replied, const Reply& reply) {
    if (replied.refusal) {
      if (goal->status == GoalStatus::STATUS_UNKNOWN) {
        report_refusal(refusal_of(replied));
        return goals_->refuse(goal, reply);
      }
      GoalAnswer ended;
      ended.error_code = kInvalidGoal;
      return goals_->end(goal, GoalStatus::STATUS_ABORTED, result_of(port_.type, ended, refusal_of(replied)));
    }
    const GoalAnswer& answer = replied.answer->as<protocol::SendMessage>();
    if (answer.feedback) return tell_feedback(*goal, answer.feedback->json());
    const std::string status = answer.status.value_or("");
    goal->number = answer.goal.value_or(0);
    if (goal->status == GoalStatus::STATUS_UNKNOWN) goals_->accept(goal, reply);
    if (status == "succeeded") goals_->end(goal, GoalStatus::STATUS_SUCCEEDED, result_of(port_.type, answer));
    if (status == "aborted")
      goals_->end(goal, GoalStatus::STATUS_ABORTED,
                  result_of(port_.type, answer, why_aborted(*goal, answer)));
    if (status == "canceled") goals_->end(goal, GoalStatus::STATUS_CANCELED, result_of(port_.type, answer));
  }

  /// The reason, where the error code does not give it.
  std::string why_aborted(const Goal& goal, const GoalAnswer& answer) const {
    if (answer.error_code != kInvalidGoal) return "";
    for (const control::ListedController& c : bridge_.cell().controllers().list())
      if (c.name == port_.controller && c.state != hardware::LifecycleState::active)
        return "the controller is not active any more";
    return asking_ > 0 || !goals_->is_newest(goal) ? "another goal took its place"
                                                   : "the motion was ended at the cell";
  }

  /// The ROS reply has no field for the reason, so it is logged in the cell. The same reason is not logged
  /// again soon.
  void report_refusal(const std::string& why) {
    const Nanoseconds now = bridge_.cell().now();
    if (why == refusal_ && now - refused_ < kReportAgain) return;
    refusal_ = why;
    refused_ = now;
    bridge_.cell().tell("ROS 2: a goal of " + port_.name + " is refused: " + why);
  }

  void tell_feedback(const Goal& goal, Json sample) {
    bridge_.to_ros(sample);
    goals_->tell_feedback(goal, feedback_of(port_.type, std::move(sample)));
  }

  Bridge& bridge_;
  ActionPort port_;
  const std::shared_ptr<GoalServer> goals_;
  int asking_ = 0;  ///< goals that the cell has not answered yet
  std::string refusal_;
  Nanoseconds refused_ = 0;
  bool closed_ = false;
};

class ActionServer : public Part {
 public:
  ActionServer(Bridge& bridge, ActionPort port) : server_{std::make_shared<Server>(bridge, std::move(port))} {
    server_->begin();
  }
  ~ActionServer() override { server_->close(); }
  void serve() override { server_->serve(); }

 private:
  std::shared_ptr<Server> server_;
};

}  // namespace

std::unique_ptr<Part> make_action_server(Bridge& bridge, ActionPort port) {
  return std::make_unique<ActionServer>(bridge, std::move(port));
}

}  // namespace polyarm::ros2
