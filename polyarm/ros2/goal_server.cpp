#include "polyarm/ros2/goal_server.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/messages/json.hpp"

namespace polyarm::ros2 {

namespace {

using Cancel = messages::action_msgs::srv::CancelGoal::Response;

/// Results of ended goals are kept this long (ns) for clients that request them later. ROS 2 keeps them for
/// ten seconds.
constexpr Nanoseconds kKept = 60'000'000'000;
constexpr std::size_t kMostKept = 100;
/// The status is published again after this time, ns. A client uses a goal's status only after it has
/// received the accepting reply, which may arrive after the status (the first reply to a Cyclone reader is
/// delayed). Without the repetition, `ros2 action send_goal` would not cancel when it is interrupted.
constexpr Nanoseconds kStatusAgain = 300'000'000;

}  // namespace

void GoalServer::begin(Owner owner) {
  owner_ = std::move(owner);
  const std::string base = name_ + "/_action/";
  feedback_type_ = &bridge_.type(type_ + "_FeedbackMessage");
  feedback_ = bridge_.wire().publisher(node_, base + "feedback", *feedback_type_);
  status_ = bridge_.wire().publisher(node_, base + "status",
                                     messages::type_info<messages::action_msgs::msg::GoalStatusArray>(),
                                     {true, true, 1});
  const auto serve = [&](const char* name, const std::string& type, auto member) {
    bridge_.service(node_, base + name, type, [self = weak_from_this(), member](Json request, Reply reply) {
      if (const auto server = self.lock()) (server.get()->*member)(std::move(request), std::move(reply));
    });
  };
  serve("send_goal", type_ + "_SendGoal", &GoalServer::send_goal);
  serve("get_result", type_ + "_GetResult", &GoalServer::get_result);
  serve("cancel_goal", "action_msgs/srv/CancelGoal", &GoalServer::cancel_goal);
  report_status();
}

void GoalServer::serve() {
  forget_old();
  if (!accepted_ || bridge_.cell().now() - *accepted_ < kStatusAgain) return;
  accepted_.reset();
  report_status();
}

void GoalServer::forget_old() {
  const Nanoseconds now = bridge_.cell().now();
  std::erase_if(goals_, [&](const auto& goal) { return goal->over() && now - goal->ended > kKept; });
  for (auto at = goals_.begin(); goals_.size() > kMostKept && at != goals_.end();)
    at = (*at)->over() ? goals_.erase(at) : std::next(at);
}

GoalPointer GoalServer::find(const Json& id) const {
  for (const GoalPointer& goal : goals_)
    if (goal->id == id) return goal;
  return nullptr;
}

void GoalServer::send_goal(Json request, Reply reply) {
  const auto goal = std::make_shared<Goal>();
  goal->id = request["goal_id"];
  goal->stamp = bridge_.ros_stamp(bridge_.cell().now());
  if (find(goal->id) || !owner_.take) return refuse(goal, reply);
  owner_.take(goal, std::move(request["goal"]), std::move(reply));
}

void GoalServer::accept(const GoalPointer& goal, const Reply& reply) {
  goal->status = GoalStatus::STATUS_EXECUTING;
  goals_.push_back(goal);
  reply({{"accepted", true}, {"stamp", goal->stamp}});
  report_status();
  accepted_ = bridge_.cell().now();
}

void GoalServer::refuse(const GoalPointer& goal, const Reply& reply) const {
  reply({{"accepted", false}, {"stamp", goal->stamp}});
}

void GoalServer::end(const GoalPointer& goal, int status, Json result) {
  if (goal->over()) return;
  goal->status = status;
  goal->result = std::move(result);
  goal->ended = bridge_.cell().now();
  report_status();
  for (const Reply& waiting : goal->waiting) waiting({{"status", goal->status}, {"result", goal->result}});
  goal->waiting.clear();
}

void GoalServer::get_result(const Json& request, Reply reply) {
  const GoalPointer goal = find(request["goal_id"]);
  if (!goal) return reply({{"status", GoalStatus::STATUS_UNKNOWN}});
  if (goal->over()) return reply({{"status", goal->status}, {"result", goal->result}});
  goal->waiting.push_back(std::move(reply));
}

/// Selects all goals if neither id nor time is given, the goals up to a time, and the goal with the id. An
/// unknown id without a time is an error; in the other cases it is no error if no goal matches.
void GoalServer::cancel_goal(Json request, const Reply& reply) {
  const Json info = std::move(request["goal_info"]);
  const bool any_id = std::all_of(info["goal_id"]["uuid"].begin(), info["goal_id"]["uuid"].end(),
                                  [](const Json& byte) { return byte == 0; });
  const std::int64_t until = nanoseconds_of(info["stamp"]);
  const GoalPointer named = any_id ? nullptr : find(info["goal_id"]);
  if (!any_id && until == 0 && !named) return reply({{"return_code", Cancel::ERROR_UNKNOWN_GOAL_ID}});
  const bool too_late = named && named->status >= GoalStatus::STATUS_CANCELING;
  if (until == 0 && too_late) return reply({{"return_code", Cancel::ERROR_GOAL_TERMINATED}});
  Json canceling = Json::array();
  std::vector<GoalPointer> meant;
  for (const GoalPointer& goal : goals_) {
    const bool is_meant =
        goal == named || (any_id && until == 0) || (until != 0 && nanoseconds_of(goal->stamp) <= until);
    if (!is_meant || goal->over() || goal->status == GoalStatus::STATUS_CANCELING) continue;
    goal->status = GoalStatus::STATUS_CANCELING;
    canceling.push_back({{"goal_id", goal->id}, {"stamp", goal->stamp}});
    meant.push_back(goal);
  }
  reply({{"return_code", Cancel::ERROR_NONE}, {"goals_canceling", std::move(canceling)}});
  if (meant.empty()) return;
  report_status();
  for (const GoalPointer& goal : meant)
    if (owner_.cancel) owner_.cancel(goal);
}

void GoalServer::tell_feedback(const Goal& goal, Json feedback) {
  if (!bridge_.is_due(told_feedback_)) return;
  const Json message{{"goal_id", goal.id}, {"feedback", std::move(feedback)}};
  bridge_.wire().publish(feedback_, messages::from_json(*feedback_type_, message));
}

void GoalServer::report_status() {
  Json list = Json::array();
  for (const GoalPointer& goal : goals_)
    list.push_back(
        {{"goal_info", {{"goal_id", goal->id}, {"stamp", goal->stamp}}}, {"status", goal->status}});
  const messages::TypeInfo& type = messages::type_info<messages::action_msgs::msg::GoalStatusArray>();
  bridge_.wire().publish(status_, messages::from_json(type, {{"status_list", std::move(list)}}));
}

}  // namespace polyarm::ros2
