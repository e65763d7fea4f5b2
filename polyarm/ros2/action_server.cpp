/// Maps a ROS 2 action to a goal of the cell: three services, feedback and status.
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "polyarm/messages/json.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

namespace {

using messages::action_msgs::msg::GoalStatus;
using Cancel = messages::action_msgs::srv::CancelGoal::Response;

/// Results of ended goals are kept this long (ns) for clients that request them later. ROS 2 keeps them for
/// ten seconds.
constexpr Nanoseconds kKept = 60'000'000'000;
constexpr std::size_t kMostKept = 100;
/// The status is published again after this time, ns. A client uses a goal's status only after it has
/// received the accepting reply, which may arrive after the status (the first reply to a Cyclone reader is
/// delayed). Without the repetition, `ros2 action send_goal` would not cancel when it is interrupted.
constexpr Nanoseconds kStatusAgain = 300'000'000;
constexpr Nanoseconds kReportAgain = 5'000'000'000;
/// Value of error_code in control_msgs/FollowJointTrajectory.
constexpr int kInvalidGoal = -1;

struct Goal {
  Json id;  ///< {"uuid": […]}
  Json stamp;
  int status = GoalStatus::STATUS_UNKNOWN;
  std::uint64_t number = 0;  ///< the cell's number of the goal, once it is accepted
  Json result = Json::object();
  std::vector<Reply> waiting;  ///< clients that wait for the result
  Nanoseconds ended = 0;
  bool over() const { return status >= GoalStatus::STATUS_SUCCEEDED; }
};

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
  Server(Bridge& bridge, ActionPort port) : bridge_{bridge}, port_{std::move(port)} {}

  void begin() {
    const std::string base = port_.name + "/_action/";
    const messages::TypeInfo& status = messages::type_info<messages::action_msgs::msg::GoalStatusArray>();
    feedback_type_ = &bridge_.type(port_.type + "_FeedbackMessage");
    feedback_ = bridge_.wire().publisher(port_.node, base + "feedback", *feedback_type_);
    status_ = bridge_.wire().publisher(port_.node, base + "status", status, {true, true, 1});
    using Self = std::weak_ptr<Server>;
    const auto serve = [&](const char* name, const std::string& type, auto member) {
      bridge_.service(port_.node, base + name, type,
                      [self = Self(weak_from_this()), member](Json request, Reply reply) {
                        if (const auto server = self.lock())
                          (server.get()->*member)(std::move(request), std::move(reply));
                      });
    };
    serve("send_goal", port_.type + "_SendGoal", &Server::send_goal);
    serve("get_result", port_.type + "_GetResult", &Server::get_result);
    serve("cancel_goal", "action_msgs/srv/CancelGoal", &Server::cancel_goal);
    report_status();
  }

  void serve() {
    forget_old();
    if (!accepted_ || bridge_.cell().now() - *accepted_ < kStatusAgain) return;
    accepted_.reset();
    report_status();
  }
  void close() { closed_ = true; }

 private:
  using GoalPointer = std::shared_ptr<Goal>;

  void forget_old() {
    const Nanoseconds now = bridge_.cell().now();
    std::erase_if(goals_, [&](const auto& goal) { return goal->over() && now - goal->ended > kKept; });
    for (auto at = goals_.begin(); goals_.size() > kMostKept && at != goals_.end();)
      at = (*at)->over() ? goals_.erase(at) : std::next(at);
  }

  GoalPointer find(const Json& id) const {
    for (const GoalPointer& goal : goals_)
      if (goal->id == id) return goal;
    return nullptr;
  }

  std::string target() const { return port_.controller + "/" + port_.port; }

  void send_goal(Json request, Reply reply) {
    const Json stamp = bridge_.ros_stamp(bridge_.cell().now());
    if (find(request["goal_id"])) return reply({{"accepted", false}, {"stamp", stamp}});
    const auto goal = std::make_shared<Goal>();
    goal->id = request["goal_id"];
    goal->stamp = stamp;
    Json message = std::move(request["goal"]);
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

  void answered(const GoalPointer& goal, const protocol::Reply& replied, const Reply& reply) {
    if (replied.refusal) {
      if (goal->status == GoalStatus::STATUS_UNKNOWN) {
        report_refusal(refusal_of(replied));
        return reply({{"accepted", false}, {"stamp", goal->stamp}});
      }
      GoalAnswer ended;
      ended.error_code = kInvalidGoal;
      return end(goal, GoalStatus::STATUS_ABORTED, result_of(port_.type, ended, refusal_of(replied)));
    }
    const GoalAnswer& answer = replied.answer->as<protocol::SendMessage>();
    if (answer.feedback) return tell_feedback(*goal, answer.feedback->json());
    const std::string status = answer.status.value_or("");
    goal->number = answer.goal.value_or(0);
    if (goal->status == GoalStatus::STATUS_UNKNOWN) accept(goal, reply);
    if (status == "succeeded") end(goal, GoalStatus::STATUS_SUCCEEDED, result_of(port_.type, answer));
    if (status == "aborted")
      end(goal, GoalStatus::STATUS_ABORTED, result_of(port_.type, answer, why_aborted(*goal, answer)));
    if (status == "canceled") end(goal, GoalStatus::STATUS_CANCELED, result_of(port_.type, answer));
  }

  /// The reason, where the error code does not give it.
  std::string why_aborted(const Goal& goal, const GoalAnswer& answer) const {
    if (answer.error_code != kInvalidGoal) return "";
    for (const control::ListedController& c : bridge_.cell().controllers().list())
      if (c.name == port_.controller && c.state != hardware::LifecycleState::active)
        return "the controller is not active any more";
    const bool newer = goals_.empty() || goals_.back().get() != &goal;
    return asking_ > 0 || newer ? "another goal took its place" : "the motion was ended at the cell";
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

  void accept(const GoalPointer& goal, const Reply& reply) {
    goal->status = GoalStatus::STATUS_EXECUTING;
    goals_.push_back(goal);
    reply({{"accepted", true}, {"stamp", goal->stamp}});
    report_status();
    accepted_ = bridge_.cell().now();
  }

  void end(const GoalPointer& goal, int status, Json result) {
    if (goal->over()) return;
    goal->status = status;
    goal->result = std::move(result);
    goal->ended = bridge_.cell().now();
    report_status();
    for (const Reply& waiting : goal->waiting) waiting({{"status", goal->status}, {"result", goal->result}});
    goal->waiting.clear();
  }

  void get_result(Json request, Reply reply) {
    const GoalPointer goal = find(request["goal_id"]);
    if (!goal) return reply({{"status", GoalStatus::STATUS_UNKNOWN}});
    if (goal->over()) return reply({{"status", goal->status}, {"result", goal->result}});
    goal->waiting.push_back(std::move(reply));
  }

  /// Selects all goals if neither id nor time is given, the goals up to a time, and the goal with the id. An
  /// unknown id without a time is an error; in the other cases it is no error if no goal matches.
  void cancel_goal(Json request, Reply reply) {
    const Json info = std::move(request["goal_info"]);
    const bool any_id = std::all_of(info["goal_id"]["uuid"].begin(), info["goal_id"]["uuid"].end(),
                                    [](const Json& byte) { return byte == 0; });
    const std::int64_t until = nanoseconds_of(info["stamp"]);
    const GoalPointer named = any_id ? nullptr : find(info["goal_id"]);
    if (!any_id && until == 0 && !named) return reply({{"return_code", Cancel::ERROR_UNKNOWN_GOAL_ID}});
    const bool too_late = named && named->status >= GoalStatus::STATUS_CANCELING;
    if (until == 0 && too_late) return reply({{"return_code", Cancel::ERROR_GOAL_TERMINATED}});
    Json canceling = Json::array();
    for (const GoalPointer& goal : goals_) {
      const bool meant =
          goal == named || (any_id && until == 0) || (until != 0 && nanoseconds_of(goal->stamp) <= until);
      if (!meant || goal->over() || goal->status == GoalStatus::STATUS_CANCELING) continue;
      goal->status = GoalStatus::STATUS_CANCELING;
      canceling.push_back({{"goal_id", goal->id}, {"stamp", goal->stamp}});
      bridge_.ask(protocol::GoalCancel{target(), static_cast<double>(goal->number)}, [](const protocol::Reply&) {});
    }
    const bool any = !canceling.empty();
    reply({{"return_code", Cancel::ERROR_NONE}, {"goals_canceling", std::move(canceling)}});
    if (any) report_status();
  }

  void tell_feedback(const Goal& goal, Json sample) {
    if (!bridge_.is_due(told_feedback_)) return;
    bridge_.to_ros(sample);
    Json message{{"goal_id", goal.id}, {"feedback", feedback_of(port_.type, std::move(sample))}};
    bridge_.wire().publish(feedback_, messages::from_json(*feedback_type_, message));
  }

  void report_status() {
    Json list = Json::array();
    for (const GoalPointer& goal : goals_)
      list.push_back(
          {{"goal_info", {{"goal_id", goal->id}, {"stamp", goal->stamp}}}, {"status", goal->status}});
    const messages::TypeInfo& type = messages::type_info<messages::action_msgs::msg::GoalStatusArray>();
    bridge_.wire().publish(status_, messages::from_json(type, {{"status_list", std::move(list)}}));
  }

  Bridge& bridge_;
  ActionPort port_;
  const messages::TypeInfo* feedback_type_ = nullptr;
  std::chrono::steady_clock::time_point told_feedback_;
  Wire::Id feedback_ = 0, status_ = 0;
  std::deque<GoalPointer> goals_;
  std::optional<Nanoseconds> accepted_;  ///< time of the last accepted goal, until its status has been sent
                                         ///< again
  int asking_ = 0;                       ///< goals that the cell has not answered yet
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
