#include "apps/console_move.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "apps/jog_keys.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

/// After a decision the cell may still report its old state for this long.
constexpr std::chrono::milliseconds kOldReport{400};

Json json_of(const data::Value& value, const std::string& name) {
  if (const data::JointState* joints = value.as_joints()) {
    Json map = Json::object();
    for (std::size_t j = 0; j < joints->names.size(); ++j) {
      const double position = joints->positions[j];
      const Dimension given = joints->given_at(j);  // the cell refuses the unit of another kind of joint
      if (given == Dimension::none)
        map[joints->names[j]] = position;
      else
        map[joints->names[j]] = format_number(position) + data::unit_text(given);
    }
    return {{"joints", map}, {"name", name}};
  }
  if (const data::Point* point = value.as_point()) {
    const Vec3& p = point->pose.position;
    const Quaternion& q = point->pose.rotation;
    Json out{{"pose", {{"position", {p.x, p.y, p.z}}, {"orientation", {q.x, q.y, q.z, q.w}}}},
             {"name", name}};
    if (!point->frame().empty() && point->frame() != "world") out["frame"] = point->frame();
    return out;
  }
  throw Error("not-a-point", "'" + name + "' is " + data::name(value.kind()) + ", not a point",
              "points are joint states and poses");
}

}  // namespace

// --- points -----------------------------------------------------------------------------------------------

Json ConsoleMove::ask_point(From from, const std::string& called) {
  switch (from) {
    case From::joints:
      return json_of(editor_.ask_joints(), called);
    case From::pose:
      return json_of(editor_.ask_pose(), called);
    case From::file: {
      const std::string file = talk_.name("File: ");
      const std::string name = talk_.name("Point of " + file + ": ");
      return json_of(editor_.value_of(file, name), name);
    }
    case From::list: {
      const std::string name = talk_.name("Point of the file that is open: ");
      const data::Value* value = editor_.values().value(name);
      if (!value)
        throw Error(
            "unknown-name",
            "the file that is open has no '" + name + "'" + did_you_mean(name, editor_.values().names()),
            "load another in the file editor");
      return json_of(outermost(*value, editor_.values()), name);
    }
  }
  return {};
}

void ConsoleMove::ask_duration(Json& point) {
  if (!manual_) return;
  const std::string to = point["name"];
  for (;;) {
    const double time = talk_.quantity("Duration of the move to " + to + " in s: ", Dimension::time);
    if (time > 0) {
      point["duration"] = time;
      return;
    }
    talk_.complain("a move takes more than 0 s");
  }
}

void ConsoleMove::move_one(From from) {
  if (from == From::file) fmt::print("{}", in_columns(editor_.files()));
  Json point = ask_point(from, from == From::joints ? "the input JS" : "the input pose");
  ask_duration(point);
  go({point});
}

std::vector<Json> ConsoleMove::ask_file_points() {
  fmt::print("{}", in_columns(editor_.files()));
  const std::string file = talk_.name("File: ");
  const std::string names = talk_.name("Points in their order, with commas between them: ");
  std::vector<Json> out;
  for (const std::string& name : split_fields(names, ',')) {
    out.push_back(json_of(editor_.value_of(file, name), name));
    ask_duration(out.back());
  }
  return out;
}

void ConsoleMove::move_many(From from) {
  if (from == From::file) return go(ask_file_points());
  const int count = talk_.number("How many points: ", 1, 1000);
  std::vector<Json> points;
  for (int i = 1; i <= count; ++i) {
    const std::string called = fmt::format("point {}", i);
    talk_.say(called);
    points.push_back(ask_point(from, called));
    ask_duration(points.back());
  }
  go(points);
}

void ConsoleMove::move_mixed() {
  talk_.say("JS: joint values, P: a pose, F: a point of a file, L: a point of the file that is open");
  std::vector<From> types;
  for (const std::string& word : split_words(talk_.name("Types in their order (JS P F L): "), " ,\t")) {
    const std::string type = lower(word);
    if (type != "js" && type != "p" && type != "f" && type != "l")
      throw Error("bad-type", "'" + word + "' is not a type of a point", "JS, P, F or L");
    types.push_back(type == "js"  ? From::joints
                    : type == "p" ? From::pose
                    : type == "f" ? From::file
                                  : From::list);
  }
  std::vector<Json> points;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const std::string called = fmt::format("point {}", i + 1);
    talk_.say(called);
    points.push_back(ask_point(types[i], called));
    ask_duration(points.back());
  }
  go(points);
}

// --- moving -----------------------------------------------------------------------------------------------

/// Reports a hold, and continues only if the user agrees.
void ConsoleMove::require_running() {
  if (!cell_.catch_up().empty()) return;
  const Json now = cell_.ask({{"request", "program"}});
  if (now["control"] != "held") return;
  if (!talk_.yes("The cell is held: " + shown(now["cause"]) + ". Go on?", true)) throw GivenUp{};
  cell_.ask({{"request", "control.resume"}});
}

void ConsoleMove::go(const std::vector<Json>& points) {
  require_running();
  Json request{{"request", "move"}, {"points", points}};
  if (!manual_ && scale_ > 0) request["pace"] = scale_;
  talk_.take_interrupt();
  follow(cell_.send(std::move(request)));
  const Json state = cell_.ask({{"request", "jog.state"}});
  talk_.say("TCP " + tcp_line(state));
}

/// Waits until the robot has arrived; Ctrl-C stops it on its path.
void ConsoleMove::follow(int id) {
  if (talk_.at_terminal()) talk_.say(talk_.dim("moving; Ctrl-C stops it on its path"));
  auto decided = Clock::now() - kOldReport;
  for (int asked = 0;;) {
    if (talk_.ended()) throw EndOfAnswers{};
    if (talk_.take_interrupt()) cell_.send({{"request", ++asked > 1 ? "control.stop" : "control.hold"}});
    const Json answer = cell_.receive(id, 50);
    if (answer.is_null()) continue;
    const Json result = Client::result_of(answer);
    if (result.value("done", false)) {
      talk_.say(fmt::format("arrived after {:.2f} s", result["elapsed_s"].get<double>()));
      return;
    }
    const std::string state = result["cell"];
    if (state == "fault")
      throw Error("fault", "the cell is in a fault", "polyarm control recover, polyarm health");
    if (state == "running") asked = 0;
    if (state != "held" || Clock::now() - decided < kOldReport) continue;
    if (const std::string why = cell_.catch_up(); !why.empty()) {
      talk_.say(talk_.dim("the simulation continued after " + why));
      decided = Clock::now();
      continue;
    }
    talk_.say("the robot was stopped on its path: " + shown(result["cause"]));
    if (!decide_when_held()) return;
    decided = Clock::now();
  }
}

/// False: the rest of the motion is discarded.
bool ConsoleMove::decide_when_held() {
  for (;;) {
    std::string answer;
    try {
      answer = talk_.line("1->Go On  2->Back Along The Path  0->Forget The Rest\n> ");
    } catch (const GivenUp&) {
      continue;
    }
    try {
      if (answer == "1") {
        cell_.ask({{"request", "control.resume"}});
        return true;
      }
      if (answer == "2") {
        cell_.ask({{"request", "control.back"}});
        continue;
      }
      if (answer == "0") {
        cell_.ask({{"request", "control.discard"}});
        cell_.ask({{"request", "control.resume"}});
        return false;
      }
      talk_.complain("'" + answer + "' is not an answer; 0, 1 or 2");
    } catch (const Error& e) {
      talk_.complain(e);
    }
  }
}

void ConsoleMove::jog(bool tcp) {
  require_running();
  if (!talk_.at_terminal()) return jog_by_lines(tcp);
  JogScreen screen;
  screen.robot = cell_.robots().size() > 1 ? cell_.robot() : "";
  screen.tcp = tcp;
  screen.keep = [this](const Json& state) {
    try {
      const bool joints = talk_.yes("Store it as a joint state (otherwise as a pose)?", true);
      const std::string name = editor_.keep(joints ? data::Value(ConsoleEditor::joints_of(state))
                                                   : data::Value(ConsoleEditor::pose_of(state)));
      return name.empty() ? std::string("not kept") : "kept as " + name;
    } catch (const GivenUp&) {
      return std::string("not kept");
    } catch (const Error& e) {
      return std::string(e.problems().front().what);
    }
  };
  jog_by_keys(cell_.client(), screen);
}

/// If keys cannot be read: one step per line, until an empty line.
void ConsoleMove::jog_by_lines(bool tcp) {
  const std::string question = tcp ? "Axis, distance and frame (z 20mm tool), empty: end: "
                                   : "Joint and distance (elbow_joint 5deg), empty: end: ";
  for (std::string line = talk_.line(question); !line.empty() && line != "0"; line = talk_.line(question)) {
    const std::vector<std::string> words = split_words(line);
    if (words.size() < 2 || words.size() > (tcp ? 3u : 2u)) {
      talk_.complain("'" + line + "' is not understood; write " + (tcp ? "z 20mm tool" : "elbow_joint 5deg"));
      continue;
    }
    Json request{{"request", "jog"}, {"by", true}};
    const auto number = parse_number(words[1]);
    request[tcp ? "tcp" : "joints"] = {{words[0], number ? Json(*number) : Json(words[1])}};
    if (words.size() > 2) request["frame"] = words[2];
    try {
      cell_.catch_up();
      const int id = cell_.send(std::move(request));
      Json answer;
      do {
        if (talk_.take_interrupt()) cell_.send({{"request", "control.hold"}});
        answer = cell_.receive(id, 100);
      } while (answer.is_null() || answer.value("more", false));
      const Json state = Client::result_of(answer);
      if (!state["done"].get<bool>()) talk_.complain("not the whole distance: " + shown(state["reason"]));
      talk_.say(tcp ? tcp_line(state) : joints_line(state));
    } catch (const Error& e) {
      if (!cell_.runs()) throw;
      talk_.complain(e);
    }
  }
}

void ConsoleMove::sliders() {
  require_running();
  if (!cell_.pendant().empty()) talk_.say("the pendant has sliders, too: " + cell_.pendant());
  if (talk_.at_terminal()) return joint_sliders(cell_);
  jog_by_lines(false);
}

// --- the menu ---------------------------------------------------------------------------------------------

void ConsoleMove::change_method() {
  manual_ = !manual_;
  talk_.say(manual_ ? "the console asks for the duration of each move"
                    : fmt::format("moves take {} s for each rad of their path in joint space",
                                  format_number(scale_)));
}

void ConsoleMove::change_scale() {
  const double scale =
      talk_.quantity(fmt::format("Seconds for each rad of the path in joint space, 0: as fast as the limits "
                                 "allow ({}): ",
                                 format_number(scale_)),
                     Dimension::none, scale_);
  if (!(scale >= 0 && scale <= 1000))
    throw Error("bad-value", fmt::format("{} s for each rad cannot be", scale), "0 to 1000");
  scale_ = scale;
}

std::vector<MenuEntry> ConsoleMove::entries() {
  return {
      {1, "RQT Joint Trajectory Controller Start", [this] { sliders(); }},
      {2, "Move Joints", [this] { jog(false); }},
      {3, "Move TCP Pose", [this] { jog(true); }},
      {4, "Move Robot To Input JS", [this] { move_one(From::joints); }},
      {5, "Move Robot To Input POSE", [this] { move_one(From::pose); }},
      {6, "Move Robot To File Point", [this] { move_one(From::file); }},
      {7, "Move Robot To Input JS Trajectory", [this] { move_many(From::joints); }},
      {8, "Move Robot To Input POSE Trajectory", [this] { move_many(From::pose); }},
      {9, "Move Robot To File Trajectory", [this] { move_many(From::file); }},
      {10, "Move Robot To Input or File Trajectory", [this] { move_mixed(); }},
      {11, manual_ ? "Change Duration Input method to Automatic" : "Change Duration Input method to Manual",
       [this] { change_method(); }},
      {12, "Change Automatic Duration Scale", [this] { change_scale(); }},
  };
}

void ConsoleMove::run() {
  const auto heading = [this] {
    return fmt::format("Move Menu   {}, duration {}", cell_.robot(),
                       manual_      ? "entered for each move"
                       : scale_ > 0 ? format_number(scale_) + " s/rad"
                                    : "as fast as the limits allow");
  };
  talk_.menu(
      heading, [this] { return entries(); }, [this] { return !cell_.runs(); });
}

}  // namespace polyarm::apps
