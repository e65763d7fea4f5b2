#pragma once
/// A cell made of a data store and a clock: moves take their time, files are read from a folder.
#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/program/interpreter.hpp"

namespace polyarm::program {

class FakeHost : public Host {
 public:
  data::DataStore store;
  std::filesystem::path folder;
  Nanoseconds time = 0;
  Nanoseconds move_time = 100'000'000;
  Nanoseconds arrives = 0;  ///< when the last move that was queued ends
  std::vector<std::string> moves;
  std::vector<std::pair<int, std::string>> logs;  ///< line, text
  std::vector<std::string> questions;
  std::vector<std::string> sets;
  std::vector<std::string> loads;
  bool answers = true;

  const data::Value* find(std::string_view name) const override { return store.find(name); }
  std::vector<std::string> names() const override { return store.names(); }
  void set(const std::string& name, data::Value value, const Location&) override {
    sets.push_back(name + "=" + value.text());
    store.set(name, std::move(value), "program");
  }
  std::uint64_t data_version() const override { return store.version(); }
  Handle start_move(const Move& move, const Location&) override {
    for (const Move::Target& target : move.targets) {
      if (target.name == "Unreachable")
        throw Error("unreachable", "'Unreachable' is 5.31 m from the base, this robot reaches 0.50 m");
      moves.push_back(target.name);
    }
    arrives = std::max(arrives, time) + move_time;
    return start(arrives);
  }
  Progress poll_move(Handle handle) override { return until(handle); }
  bool room_for_move(const std::string&) override { return true; }
  Handle start_arrival(const std::string&) override { return start(std::max(arrives, time)); }
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
  Progress poll_ask(Handle handle) override { return answers ? until(handle) : Progress{}; }
  Nanoseconds now() const override { return time; }
  void log(const std::string& text, const Location& where) override { logs.emplace_back(where.line, text); }

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
