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

/// A row of the table and what carries it out.
struct RequestRow {
  RequestInfo info;
  Handler handler;
};
/// Those about points, files and texts of the project.
const std::vector<RequestRow>& project_rows();

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

/// A switch that is begun again when the loop changed something by itself meanwhile.
Poll switch_controllers(Cell& cell, control::SwitchRequest request, Json answer);
/// Stops who uses the component, then takes it there.
Poll take_to(Cell& cell, std::size_t component, hardware::LifecycleState wanted);
/// Two steps one after the other; the second may be told what the first answered.
Poll then(Poll first, std::function<Poll(Cell&)> second);
Poll then_with(Poll first, std::function<Poll(Cell&, Json)> second);

Poll control_list(Cell&, const Json&);
Poll control_types(Cell&, const Json&);
Poll control_chains(Cell&, const Json&);
Poll control_switch(Cell&, const Json&);
Poll control_load(Cell&, const Json&);
Poll control_configure(Cell&, const Json&);
Poll control_cleanup(Cell&, const Json&);
Poll control_unload(Cell&, const Json&);
Poll control_state(Cell&, const Json&);
Poll control_arm(Cell&, const Json&);
Poll control_hold(Cell&, const Json&);
Poll control_stop(Cell&, const Json&);
Poll control_resume(Cell&, const Json&);
Poll control_discard(Cell&, const Json&);
Poll control_recover(Cell&, const Json&);
Poll control_back(Cell&, const Json&);
Poll control_override(Cell&, const Json&);
Poll hardware_list(Cell&, const Json&);
Poll hardware_state(Cell&, const Json&);
Poll hardware_recover(Cell&, const Json&);
Poll hardware_reload(Cell&, const Json&);
Poll interfaces_list(Cell&, const Json&);
Poll health(Cell&, const Json&);
Poll limits_list(Cell&, const Json&);
Poll param_list(Cell&, const Json&);
Poll param_get(Cell&, const Json&);
Poll param_set(Cell&, const Json&);
Poll send_message(Cell&, const Json&);
Poll goal_cancel(Cell&, const Json&);
Poll watch_output(Cell&, const Json&);
Poll jog(Cell&, const Json&);
Poll jog_state(Cell&, const Json&);
Poll target(Cell&, const Json&);
Poll profile(Cell&, const Json&);
Poll tags_list(Cell&, const Json&);
Poll tags_set(Cell&, const Json&);
Poll tags_force(Cell&, const Json&);
Poll record_state(Cell&, const Json&);
Poll record_start(Cell&, const Json&);
Poll record_stop(Cell&, const Json&);
Poll tags_release(Cell&, const Json&);
Poll tags_history(Cell&, const Json&);
Poll points(Cell&, const Json&);
Poll points_here(Cell&, const Json&);
Poll points_teach(Cell&, const Json&);
Poll points_set(Cell&, const Json&);
Poll points_shift(Cell&, const Json&);
Poll points_rename(Cell&, const Json&);
Poll points_delete(Cell&, const Json&);
Poll points_history(Cell&, const Json&);
Poll points_undo(Cell&, const Json&);
Poll points_frame(Cell&, const Json&);
Poll points_tool(Cell&, const Json&);
Poll plan_preview(Cell&, const Json&);
Poll files(Cell&, const Json&);
Poll files_read(Cell&, const Json&);
Poll files_draft(Cell&, const Json&);
Poll files_write(Cell&, const Json&);
Poll files_versions(Cell&, const Json&);
Poll files_version(Cell&, const Json&);
Poll files_delete(Cell&, const Json&);
Poll files_rename(Cell&, const Json&);
Poll language_words(Cell&, const Json&);
Poll program_check(Cell&, const Json&);
Poll program_steps(Cell&, const Json&);
Poll program_names(Cell&, const Json&);
Poll cell_restart(Cell&, const Json&);
Poll program_state(Cell&, const Json&);
Poll program_watch(Cell&, const Json&);
Poll program_pause(Cell&, const Json&);
Poll program_go(Cell&, const Json&);
Poll program_step(Cell&, const Json&);
Poll program_break(Cell&, const Json&);
Poll program_from(Cell&, const Json&);
Poll program_stop(Cell&, const Json&);
Poll program_load(Cell&, const Json&);
Poll program_start(Cell&, const Json&);
Poll program_answer(Cell&, const Json&);
/// Where the program is, as all of these answer.
Json program_json(Cell& cell);
Poll move(Cell&, const Json&);
Poll events(Cell&, const Json&);
/// The parts that grippers hold, and what a program that begins in the middle takes for given.
Json held_parts(Cell& cell);
Json assumed(Cell& cell, const program::StartReport& report);

}  // namespace polyarm::cell
