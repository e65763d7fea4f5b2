/// Verbs that send messages to controllers and show what controllers publish.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <system_error>
#include <thread>

#include "apps/client.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

struct SendArguments {
  ClientOptions client;
  std::string to, file;
  double rate = 0;
  bool goal = false, once = false;
};

/// The text of a file or of standard input, or the argument itself if it is a message.
std::string text_given(const std::string& file) {
  if (file == "-") return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
  const bool says_something = file.find_first_of("{[\n") != std::string::npos ||
                              file.find(": ") != std::string::npos || parse_number(file);
  if (says_something && !std::ifstream(file)) return file;  // the message itself
  return read_file(file);
}

/// Splits a YAML stream into its documents, which `---` lines separate.
std::vector<std::string> documents(const std::string& text) {
  std::vector<std::string> out(1);
  std::size_t begin = 0;
  while (begin < text.size()) {
    const auto end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    if (line.starts_with("---")) {
      if (!trim(out.back()).empty()) out.emplace_back();
    } else {
      out.back() += line + "\n";
    }
    begin = end + 1;
  }
  if (out.size() > 1 && trim(out.back()).empty()) out.pop_back();  // `ros2 topic echo` ends with ---
  return out;
}

/// Names and values of a message without a special format: "position 0.04  effort 10".
std::string fields_text(const Json& value, const std::string& name) {
  constexpr std::size_t kMost = 400;  // characters
  if (!value.is_object()) return name.empty() ? shown(value) : name + " " + shown(value);
  std::string out;
  for (const auto& [key, inner] : value.items()) {
    if (key == "header" || out.size() > kMost) continue;
    out += (out.empty() ? "" : "  ") + fields_text(inner, name.empty() ? key : name + "." + key);
  }
  return out;
}

/// Feedback differs by controller: a trajectory's has joints with errors, a gripper's a position.
std::string feedback_text(const Json& feedback) {
  const Json& joints = part(feedback, {"joint_names"});
  const Json& errors = part(feedback, {"error", "positions"});
  if (!joints.is_array() || !errors.is_array() || joints.size() != errors.size())
    return "          " + fields_text(feedback, "");
  std::string out = fmt::format("{:>8} s  off by", shown(part(feedback, {"reference", "time_from_start"})));
  for (std::size_t j = 0; j < joints.size(); ++j)
    out += fmt::format("  {} {}", shown(joints[j]), shown(errors[j]));
  return out;
}

void tell_result(const Json& line) {
  fmt::print("goal {} {}{}\n", shown(part(line, {"goal"})), shown(part(line, {"status"})),
             line.contains("error") ? " (" + shown(line["error"]) + ")" : "");
  if (line.contains("reached_goal"))
    fmt::print("at {}{}{}\n", shown(part(line, {"position"})),
               flag_of(part(line, {"reached_goal"})) ? ", reached" : ", not reached",
               flag_of(part(line, {"stalled"})) ? ", stalled" : "");
  if (line.contains("joint"))
    fmt::print("{} is off by {}, allowed are {}\n", shown(line["joint"]), shown(part(line, {"off_by"})),
               shown(part(line, {"tolerance"})));
  if (line.contains("note")) fmt::print("{}\n", shown(line["note"]));
}

void tell_goal(const Json& line, bool json) {
  if (json)
    fmt::print("{}\n", line.dump());
  else if (line.contains("feedback"))
    fmt::print("{}\n", feedback_text(line["feedback"]));
  else
    tell_result(line);
  std::fflush(stdout);
}

/// Follows a goal to its end; the first Ctrl-C cancels the goal.
int follow(Client& client, const SendArguments& a) {
  bool canceled = false;
  Json goal;
  for (;;) {
    if (interrupted() && !canceled && !goal.is_null()) {
      canceled = true;
      client.send({{"request", "goal.cancel"}, {"to", a.to}, {"goal", goal}, {"id", "cancel"}});
    }
    const Json answer = client.receive(100);
    if (answer.is_null() || part(answer, {"id"}) == "cancel") continue;
    const Json result = Client::result_of(answer);
    if (result.contains("goal")) goal = result["goal"];
    try {
      tell_goal(result, a.client.json);
    } catch (const std::system_error&) {  // nobody reads the output: cancel the goal in the next round
    }
    if (flag_of(part(answer, {"more"}))) continue;
    const std::string status = text_of(part(result, {"status"}));
    if (status == "canceled") return kStopped;
    return status == "succeeded" ? kOk : kFailed;
  }
}

int send(const SendArguments& a) {
  const std::vector<std::string> messages = documents(text_given(a.file));
  Client client(a.client.cell);
  if (a.goal) {
    client.send({{"request", "send"}, {"to", a.to}, {"message", messages.front()}, {"goal", true}});
    return follow(client, a);
  }
  auto due = std::chrono::steady_clock::now();
  Json result;
  for (std::size_t i = 0; !interrupted(); ++i) {
    if (i >= messages.size() && (a.once || a.rate <= 0 || messages.size() > 1)) break;
    result = client.ask(
        {{"request", "send"}, {"to", a.to}, {"message", messages[std::min(i, messages.size() - 1)]}});
    if (result.contains("goal") && a.client.json) fmt::print("{}\n", result.dump());
    if (a.rate <= 0) continue;
    due += std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / a.rate));
    std::this_thread::sleep_until(due);
  }
  const std::string to = text_of(part(result, {"to"}));
  if (!a.client.json) fmt::print("sent to {}\n", to.empty() ? a.to : to);
  return kOk;
}

bool is_joint_states(const Json& message) {
  const Json &names = part(message, {"name"}), &positions = part(message, {"position"});
  return names.is_array() && positions.is_array() && names.size() == positions.size();
}

void print_joint_states(const Json& m) {
  std::string line = fmt::format("{:10.3f}", number_of(part(m, {"header", "stamp", "sec"})) +
                                                 number_of(part(m, {"header", "stamp", "nanosec"})) * 1e-9);
  for (std::size_t j = 0; j < m["name"].size(); ++j)
    line += fmt::format("  {} {}", shown(m["name"][j]), shown(m["position"][j]));
  fmt::print("{}\n", line);
}

void print_message(const Json& message, bool json) {
  if (json)
    fmt::print("{}\n", message.dump());
  else if (is_joint_states(message))
    print_joint_states(message);
  else
    fmt::print("{}\n---\n", message.dump(1));
  std::fflush(stdout);
}

/// Time without a message after which `watch` prints the reason, s.
constexpr double kTimeout = 2;

int watch(Client& client, const std::string& name, double rate, int count, bool json) {
  client.send({{"request", "watch"}, {"name", name}, {"rate", rate}, {"patience", kTimeout}});
  for (int seen = 0; !interrupted() && (count <= 0 || seen < count);) {
    const Json answer = client.receive(200);
    if (answer.is_null()) continue;
    const Json message = Client::result_of(answer);
    if (message.contains("waiting")) {
      fmt::print(stderr, "polyarm watch: {}; {}\n", shown(part(message, {"what"})),
                 shown(part(message, {"advice"})));
      continue;
    }
    ++seen;
    print_message(message, json);
  }
  return kOk;
}

}  // namespace

int run_send(int argc, char** argv) {
  CommandLine app("Sends a message to a controller of a running cell", "polyarm send");
  SendArguments a;
  app.add_option("controller", a.to, "a controller, controller/input, or a topic of ROS")->required();
  app.add_option("file", a.file,
                 "YAML or JSON in the form of the ROS message; - for standard input, or the text itself")
      ->required();
  app.add_option("--rate", a.rate,
                 "repeat at this rate, Hz, until Ctrl-C; several documents (---) are sent once each, one "
                 "after the other")
      ->positive();
  app.add_flag("--once", a.once, "once, whatever the rate");
  app.add_flag("--goal", a.goal, "as a goal: prints feedback and result; Ctrl-C cancels");
  a.client.add_to(app);
  app.footer(examples({"polyarm send r6bot_controller examples/r6bot/ellipse.yaml",
                       "polyarm send joint_trajectory_controller goal.yaml --goal",
                       "polyarm send /cmd_vel '{linear: {x: 0.1}}' --rate 10",
                       "polyarm send /MyRobot/JointA_EffortController/command '{data: 2.5}'"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  catch_interrupts();
  return send(a);
}

int run_watch(int argc, char** argv) {
  CommandLine app("Shows the output of a controller of a running cell", "polyarm watch");
  ClientOptions options;
  std::string name;
  double rate = 10;
  int count = 0;
  app.add_option("name", name, "joint_states, odom, wrench, imu, controller_state, or controller/output")
      ->required();
  app.add_option("--rate", rate, "messages a second at most")->positive();
  app.add_option("--count", count, "end after this many");
  options.add_to(app);
  app.footer(examples(
      {"polyarm watch joint_states", "polyarm watch joint_trajectory_controller/controller_state --json"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  catch_interrupts();
  Client client(options.cell);
  return watch(client, name, rate, count, options.json);
}

}  // namespace polyarm::apps
