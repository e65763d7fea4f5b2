#pragma once
/// A cell made of a data store and a clock: moves take their time, files are read from a folder.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::program {

class FakeHost : public Host {
 public:
  data::DataStore store;
  std::filesystem::path folder;
  Nanoseconds time = 0;
  Nanoseconds move_time = 100'000'000;
  struct Queued {
    Move move;
    Location where;
    Nanoseconds begin = 0, end = 0;
    bool ended = false;  ///< by end_move()
    bool fails = false;  ///< a target called Late…: told when it should have arrived
  };
  std::vector<Queued> queued;
  std::map<std::string, Nanoseconds> arrivals;     ///< by robot, when all of its moves have ended
  std::vector<std::pair<int, std::string>> asked;  ///< line, the move in words
  std::vector<std::string> ended_moves, holds;
  std::vector<Nanoseconds> suspensions;  ///< when a trap stopped the robots
  std::size_t room = 1000, most_open = 0;
  int arrivals_requested = 0;
  bool dropped = false;  ///< somebody stopped the robot
  std::vector<std::string> moves;
  std::vector<std::pair<int, std::string>> logs;  ///< line, text
  std::vector<std::string> questions;
  std::vector<std::string> sets;
  std::vector<std::string> loads;
  bool answers = true;
  std::vector<std::string> given_answers, programs, calls;

  const data::Value* find(std::string_view name) const override { return store.find(name); }
  std::vector<std::string> names() const override { return store.names(); }
  void set(const std::string& name, data::Value value, const Location&) override {
    sets.push_back(name + "=" + value.text());
    store.set(name, std::move(value), "program");
  }
  std::uint64_t data_version() const override { return store.version(); }
  Handle start_move(const Move& move, const Location& where) override {
    for (const Move::Target& target : move.targets) {
      if (target.name == "Unreachable")
        throw Error("unreachable", "'Unreachable' is 5.31 m from the base, this robot reaches 0.50 m");
      moves.push_back(target.name);
    }
    asked.emplace_back(where.line, described(move));
    Nanoseconds& arrives = arrivals[move.robot];
    const Nanoseconds begin = std::max(arrives, time);
    arrives = begin + (move.duration ? nanoseconds(move.duration->value) : move_time);
    const bool fails = move.targets.back().name.starts_with("Late");
    queued.push_back({move, where, begin, arrives, false, fails});
    return start(arrives);
  }
  Progress poll_move(Handle handle) override {
    if (dropped) return Progress::ended({"discarded", {}, "the move was discarded", {}});
    if (until(handle).state == Progress::State::running) return {};
    for (Queued& each : queued)
      if (each.end <= time && std::exchange(each.fails, false))
        return Progress::failed(
            {"unreachable", each.where, "'" + each.move.targets.back().name + "' is out of reach", {}});
    return Progress::done();
  }
  bool under_way(Handle handle) const override { return ends_.at(static_cast<std::size_t>(handle)) > time; }
  bool room_for_move(const std::string& robot) override {
    std::size_t open = 0;
    for (const Queued& each : queued) open += each.move.robot == robot && each.end > time;
    most_open = std::max(most_open, open);
    return open < room;
  }
  Handle start_arrival(const std::string& robot) override {
    ++arrivals_requested;
    return start(std::max(arrivals[robot], time));
  }
  void end_move(Handle handle, const Location&) override {
    ends_.at(static_cast<std::size_t>(handle)) = time;
    ended_moves.push_back(queued.back().move.targets.back().name);
    arrivals[queued.back().move.robot] = queued.back().end = time;
    queued.back().ended = true;
  }
  /// The open moves stand still until resume().
  Handle suspend(const std::vector<std::string>&) override {
    suspensions.push_back(time);
    suspended_handles_ = ends_.size();
    set_apart_ = std::exchange(arrivals, {});
    return start(time + 4'000'000);
  }
  Handle resume(const std::vector<std::string>&) override {
    const Nanoseconds since = suspensions.back(), more = time - since + 4'000'000;
    for (std::size_t i = 0; i < suspended_handles_; ++i)
      if (ends_[i] > since) ends_[i] += more;
    for (Queued& each : queued)
      if (each.begin <= since && each.end > since) each.end += more;
    arrivals = std::exchange(set_apart_, {});
    for (auto& [robot, end] : arrivals)
      if (end > since) end += more;
    return start(time + 4'000'000);
  }
  Travel travel(Handle handle) const override {
    const Nanoseconds end = ends_.at(static_cast<std::size_t>(handle));
    const auto at = std::find_if(queued.begin(), queued.end(), [&](const Queued& q) { return q.end == end; });
    if (at != queued.end() && at->ended) return {std::numeric_limits<double>::infinity(), 0, end, 0};
    const Nanoseconds begin = at == queued.end() ? end : at->begin;
    const Nanoseconds now = std::clamp(time, begin, end);
    const double share =
        end > begin ? static_cast<double>(now - begin) / static_cast<double>(end - begin) : 1;
    return {share, 1 - share, now - begin, end - now};  // every move is one metre long
  }
  data::Value here(const std::string&, const std::string&, const std::string&) const override {
    for (auto each = queued.rbegin(); each != queued.rend(); ++each)
      if (each->end <= time && each->move.targets.back().value.as_point())
        return each->move.targets.back().value;
    return data::Point{};
  }
  data::JointState here_joints(const std::string&) const override { return {{"elbow"}, {0.25}}; }
  data::JointState joints_at(const data::Value& place, const data::JointState* near, const std::string&,
                             const std::string&, const std::string&) const override {
    if (place.as_joints()) return *place.as_joints();
    return {{"elbow"}, {place.as_point()->pose.position.x + (near ? near->positions.front() : 0)}};
  }
  data::Value pose_at(const data::JointState& joints, const std::string&, const std::string&,
                      const std::string&) const override {
    return data::Point{{{joints.positions.front(), 0, 0}, {}}};
  }
  std::array<double, 6> wrench(const std::string&) override { return {0, 0, 30 - zero_force_}; }
  void zero_force(const std::string&) override { zero_force_ = 30; }
  void comply(const std::string&, const Compliance&) override {}
  void stiff(const std::string&) override {}
  bool next_part(const std::string&, const std::string&) override { return true; }
  double waiting_parts(const std::string&) override { return 1; }
  double missed_parts(const std::string&) override { return 0; }
  void add_part(const std::string&, const Pose&) override {}
  data::List rows_of(const std::string&) override {
    return {data::Record{{"name", "x"}, {std::string("lid"), data::Number{0.0125, Dimension::length}}}};
  }
  bool is_connected(const std::string&) override { return true; }
  bool has_line(const std::string&) override { return true; }
  std::string next_line(const std::string&) override { return "12;ok"; }
  void send_text(const std::string&, const std::string&) override {}
  std::uint64_t seed() const override { return 7; }
  bool standing() const override {
    return std::all_of(queued.begin(), queued.end(), [&](const Queued& q) { return q.end <= time; });
  }
  void hold(const std::string& reason, const Location&) override { holds.push_back(reason); }
  Handle start_load(const std::string& name, LoadForm, const Location& where) override {
    const auto path = data::find_file(name, folder, where);
    load_now(path);
    const auto information = data::script_information(files.at(path.string()).values());
    if (information && information->point_file) load_now(data::find_file(*information->point_file, folder));
    loads.push_back(name);
    return start(time + 2'000'000);
  }
  Progress poll_load(Handle handle) override { return until(handle); }
  Handle start_ask(const std::string& text, const Location&) override {
    questions.push_back(text);
    return start(time + 10'000'000);
  }
  std::string answer(const data::Value&) const override {
    const std::size_t i = questions.size() - 1;
    return i < given_answers.size() ? given_answers[i] : "";
  }
  void run_program(const std::string& name, const Location&) override { programs.push_back(name); }
  data::Value call(std::string_view function, std::span<const data::Value> arguments,
                   const Location&) override {
    calls.push_back(std::string(function) + "(" + arguments.front().text() + ")");
    if (function == "part") return data::Point{};
    return true;
  }
  Progress poll_ask(Handle handle) override { return answers ? until(handle) : Progress{}; }
  Nanoseconds now() const override { return time; }
  void log(const std::string& text, const Location& where) override { logs.emplace_back(where.line, text); }

  static std::string described(const Move& move) {
    static constexpr const char* kKinds[] = {"joint", "line", "arc", "drive", "turn"};
    std::string out = kKinds[static_cast<int>(move.kind)];
    for (const Move::Target& target : move.targets) out += " " + target.name;
    const auto number = [&](const char* word, const std::optional<data::Number>& value) {
      if (value) out += std::string(" ") + word + " " + data::Value(*value).text();
    };
    number("payload", move.payload);
    if (move.around) out += *move.around ? " around true" : " around false";
    if (move.near) out += " near " + data::Value(*move.near).text();
    number("speed", move.speed), number("accel", move.accel);
    number("blend", move.blend), number("duration", move.duration);
    for (const auto& [word, name] :
         {std::pair{"robot", move.robot}, {"tool", move.tool}, {"frame", move.frame}})
      if (!name.empty()) out += std::string(" ") + word + " " + name;
    if (move.smooth) out += " smooth";
    if (move.touch) out += " touch";
    return out + (move.exact ? " exact" : "") + (move.waits ? " waits" : "");
  }

  /// The files as they are now, with everything written through.
  std::map<std::string, data::ImportFile> files;

 private:
  void load_now(const std::filesystem::path& path) {
    if (!files.contains(path.string())) files.emplace(path.string(), data::ImportFile::load(path.string()));
    for (const data::PendingWrite& write : store.take_writes())
      files.at(write.set).set(write.name, write.value);
    store.load(path.string(), files.at(path.string()).values(), "load");
  }
  Handle start(Nanoseconds end) {
    ends_.push_back(end);
    return static_cast<Handle>(ends_.size()) - 1;
  }
  Progress until(Handle handle) const {
    return time >= ends_.at(static_cast<std::size_t>(handle)) ? Progress::done() : Progress{};
  }
  std::vector<Nanoseconds> ends_;
  std::size_t suspended_handles_ = 0;
  double zero_force_ = 0;
  std::map<std::string, Nanoseconds> set_apart_;
};

/// Steps the program every 2 ms of the host's clock until it ends or `most` has passed.
inline StepResult run(Interpreter& interpreter, FakeHost& host, Nanoseconds most = nanoseconds(3600),
                      const std::function<void()>& each_tick = {}) {
  StepResult result = interpreter.step(100);
  while ((result.state == TaskState::running || result.state == TaskState::waiting) && host.time < most) {
    host.time += 2'000'000;
    if (each_tick) each_tick();
    result = interpreter.step(100);
  }
  return result;
}

}  // namespace polyarm::program
