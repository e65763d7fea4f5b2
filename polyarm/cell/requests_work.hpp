#pragma once
/// How requests are done. Private to the room.
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/requests.hpp"

namespace polyarm::cell {

using Json = nlohmann::json;

/// What a request has come to: nothing yet, an answer that is followed by more, or the last one.
struct Progress {
  std::optional<Json> answer;
  bool over = false;
  static Progress done(Json answer) { return {std::move(answer), true}; }
  static Progress more(Json answer) { return {std::move(answer), false}; }
};
/// Asked once each tick until it is over; may throw Error, which ends it.
using Poll = std::function<Progress(Cell&)>;
/// Begins a request; may throw Error.
using Handler = Poll (*)(Cell&, const Json& arguments);

/// A row of the table and what carries it out. An urgent one is begun though earlier ones are not answered.
struct RequestRow {
  RequestInfo info;
  Handler handler;
  bool urgent = false;
};
/// The table by families; each is written beside what carries it out.
const std::vector<RequestRow>& controller_rows();
const std::vector<RequestRow>& motion_rows();
const std::vector<RequestRow>& tag_rows();
const std::vector<RequestRow>& hardware_rows();
const std::vector<RequestRow>& health_rows();
const std::vector<RequestRow>& message_rows();
const std::vector<RequestRow>& jog_rows();
const std::vector<RequestRow>& move_rows();
const std::vector<RequestRow>& load_rows();
const std::vector<RequestRow>& program_rows();
const std::vector<RequestRow>& record_rows();
const std::vector<RequestRow>& point_rows();
const std::vector<RequestRow>& frame_rows();
const std::vector<RequestRow>& preview_rows();
const std::vector<RequestRow>& file_rows();
const std::vector<RequestRow>& text_rows();
const std::vector<RequestRow>& cells_rows();
const std::vector<RequestRow>& connect_rows();

/// What rows are written with.
inline constexpr auto kText = ArgumentType::text;
inline constexpr auto kNumber = ArgumentType::number;
inline constexpr auto kFlag = ArgumentType::flag;
inline constexpr auto kNames = ArgumentType::names;
inline constexpr auto kMap = ArgumentType::map;
inline constexpr auto kAny = ArgumentType::any;
inline const std::vector<RequestArgument> kName = {{"name", kText, true}};
inline constexpr const char* kProgram =
    "{state, control, cause, holder, folder, robots, held, events, file, hash, paused, where: {file, line}, "
    "source, sentence, passes, breakpoints, question, problem, tasks: [{name, state, where, source, "
    "waits_for, names, text, passes, paused, calls, variables: [{name, value}], robot, tool, frame, "
    "problem}]}";

/// A request from its text, and whether its arguments are those that its row has. Throw Error("bad-request")
/// and Error("bad-argument").
Json parse_request(const std::string& line);
void check_arguments(const Json& request, const RequestInfo& info);

inline Poll at_once(Json answer) {
  return [answer = std::move(answer)](Cell&) { return Progress::done(answer); };
}

/// Arguments; each throws Error("bad-argument") that names it.
std::string text_argument(const Json& arguments, const char* name);
std::string text_argument(const Json& arguments, const char* name, const std::string& fallback);
std::vector<std::string> list_argument(const Json& arguments, const char* name);
bool flag_argument(const Json& arguments, const char* name);
double number_argument(const Json& arguments, const char* name, double fallback);
/// The index of the robot that 'robot' names; the only one where it names none.
std::size_t robot_argument(Cell& cell, const Json& arguments);

/// `state` as a state of the life cycle.
hardware::LifecycleState state_argument(const Json& arguments);
/// The state of a controller by name. Throws Error("unknown-controller").
hardware::LifecycleState controller_state(Cell& cell, const std::string& name);
/// How often a second the component is read and written, and the controller updated.
double rate_of(Cell& cell, const hardware::HostedInfo& info);
double rate_of(Cell& cell, const control::ListedController& controller);
/// The value; null where it is NaN or infinite, which JSON has no word for.
Json finite_or_null(double value);

/// A switch that is begun again when the loop changed something by itself meanwhile.
Poll switch_controllers(Cell& cell, control::SwitchRequest request, Json answer);
/// Stops who uses the component, then takes it there.
Poll take_to(Cell& cell, std::size_t component, hardware::LifecycleState wanted);
/// Two steps one after the other; the second may be told what the first answered.
Poll then(Poll first, std::function<Poll(Cell&)> second);
Poll then_with(Poll first, std::function<Poll(Cell&, Json)> second);

/// Where the program is, as all of these answer.
Json program_json(Cell& cell);
/// What a program that begins in the middle takes for given.
Json assumed(Cell& cell, const program::StartReport& report);

}  // namespace polyarm::cell
