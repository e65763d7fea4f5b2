/// A simulated cell that a Python program steps. The mutex keeps other Python threads out while the lock of
/// the interpreter is released; whoever holds it never needs that lock.
#include <pybind11/stl.h>

#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/mock/mock.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/protocol/any.hpp"
#include "python/bindings.hpp"

namespace polyarm::python {

namespace {
namespace fs = std::filesystem;

constexpr std::size_t kMostEvents = 10'000;

struct Event {
  double time = 0;
  std::string kind, text, where;
};

/// Keeps what a cell reports until Python takes it; the oldest are dropped.
class Listener : public cell::Observer {
 public:
  void on_note(const std::string& text) override { add({now_, "note", text, {}}); }
  void on_line(Nanoseconds time, const std::string&, const Location& where,
               const std::string& source) override {
    add({seconds(time), "line", source, where.text()});
  }
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override {
    add({seconds(time), "tag", name + " = " + value, who});
  }
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    add({seconds(time), "log", text, task});
  }
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override {
    add({seconds(time), "state", state, cause.what});
  }
  void on_question(const std::string& text) override { add({now_, "question", text, {}}); }
  void on_problem(Nanoseconds time, const Problem& problem) override {
    add({seconds(time), "problem", problem.text(), problem.code});
  }
  std::vector<Event> take() {
    std::vector<Event> out(events_.begin(), events_.end());
    events_.clear();
    return out;
  }

 private:
  void add(Event event) {
    now_ = event.time;
    if (events_.size() == kMostEvents) events_.pop_front();
    events_.push_back(std::move(event));
  }
  std::deque<Event> events_;
  double now_ = 0;
};

cell::CellFile open(const std::string& path, const cell::Overrides& overrides) {
  std::error_code error;
  const fs::path named = path;
  const std::string extension = named.extension().string();
  if (fs::exists(named / "cell.yaml", error) || extension == ".yaml" || extension == ".yml")
    return cell::read_cell_file(named, overrides);
  return cell::cell_from_description(named, {}, overrides);
}

class LockStepCell {
 public:
  LockStepCell(const std::string& path, cell::Overrides overrides, cell::CellOptions options)
      : path_(path), overrides_(std::move(overrides)), options_(std::move(options)) {
    options_.lock_step = true;
    build();
  }
  ~LockStepCell() { end(); }

  void reset() {
    const std::lock_guard lock(mutex_);
    end();
    listener_ = {};
    build();
  }

  /// `cycles` of the control loop; a tick of the cell before each cycle that needs one.
  void step(std::size_t cycles) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < cycles; ++i) step_once();
  }

  /// The answer to a request, as JSON. Time goes on until it is there, at most `patience` s of cell time.
  /// `follow`: to the last of several answers.
  std::string ask(const std::string& request, const std::string& id, bool follow, double patience) {
    const std::lock_guard lock(mutex_);
    auto answer = std::make_shared<Answer>();
    the_cell().requests().handle(
        request,
        [answer](const std::string& line) {
          answer->more = line.find("\"more\":true") != std::string::npos;
          answer->line = line;
          return true;
        },
        this);
    const Nanoseconds until = loop().cycle().time + nanoseconds(patience);
    while ((answer->line.empty() || (follow && answer->more)) && loop().cycle().time < until) {
      hardware::Hardware& hardware = loop().hardware();
      for (std::size_t i = 0; i < hardware.size(); ++i)  // callbacks may run on threads of their own
        if (const hardware::Transition* pending = hardware.pending(i)) pending->wait(kCallbackPatience);
      step_once();
    }
    if (answer->line.empty() || answer->more) cell_->requests().end(this, protocol::Any(id));
    return answer->line;
  }

  double time() const { return seconds(loop().cycle().time); }
  double period() const { return seconds(loop().options().period); }
  std::vector<std::string> state_names() const {
    return named(table().state_names(), table().built_states());
  }
  std::vector<std::string> command_names() const {
    return named(table().command_names(), table().built_commands());
  }
  Numbers states() const {
    const std::lock_guard lock(mutex_);
    return copied(table().states(), table().built_states());
  }
  Numbers commands() const {
    const std::lock_guard lock(mutex_);
    return copied(table().commands(), table().built_commands());
  }
  std::vector<Event> take_events() {
    const std::lock_guard lock(mutex_);
    return listener_.take();
  }
  std::string loop_state() const { return control::name(loop().supervisor().state()); }
  bool finished() const { return inside().life->finished(); }
  /// Why the cell cannot go on: code and text; empty while it can.
  std::pair<std::string, std::string> failure() const {
    const auto& failure = inside().life->failure();
    if (!failure) return {};
    return {failure->problem.code, failure->problem.text()};
  }

 private:
  static constexpr Nanoseconds kCallbackPatience = 60'000'000'000;
  struct Answer {
    std::string line;
    bool more = false;
  };

  void build() {
    const description::Catalogue catalogue(description::default_catalogue_folders());
    cell_ = std::make_unique<cell::Cell>(open(path_, overrides_), catalogue, options_, listener_);
    loop().begin();
    next_tick_ = 0;
  }
  void end() {
    if (!cell_) return;
    loop().end();
    cell_.reset();
  }
  void step_once() {
    if (loop().cycle().time >= next_tick_) {
      next_tick_ = loop().cycle().time + cell::Cell::kTick;
      the_cell().tick(loop().cycle().time);
    }
    loop().step_next();
  }
  cell::Cell& the_cell() const {
    if (!cell_) throw Error("no-cell", "the cell could not be built anew", "make another Cell");
    return *cell_;
  }
  cell::CellInside& inside() const { return cell::inside_of(the_cell()); }
  control::ControlLoop& loop() const { return inside().machine.loop(); }
  const hardware::InterfaceTable& table() const { return loop().table(); }
  static std::vector<std::string> named(const std::vector<std::string>& names, std::size_t count) {
    return {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  static Numbers copied(std::span<const double> values, std::size_t count) {
    return Numbers(static_cast<py::ssize_t>(count), values.data());
  }

  std::string path_;
  cell::Overrides overrides_;
  cell::CellOptions options_;
  Listener listener_;
  std::unique_ptr<cell::Cell> cell_;
  Nanoseconds next_tick_ = 0;
  mutable std::mutex mutex_;
};
}  // namespace

void add_cells(py::module_& module) {
  hardware::register_driver("mock",
                            [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
  py::class_<LockStepCell>(module, "LockStepCell")
      .def(py::init([](const std::string& path, const std::string& robot, const std::string& hardware,
                       const std::string& program, const std::string& state_folder, bool waits,
                       bool allow_contact, const std::vector<std::string>& answers) {
        cell::CellOptions options;
        options.waits = waits;
        options.allow_contact = allow_contact;
        options.answers = answers;
        options.state_folder = state_folder;
        const py::gil_scoped_release others;
        return std::make_unique<LockStepCell>(path, cell::Overrides{robot, hardware, program, 0}, options);
      }))
      .def("reset", &LockStepCell::reset, py::call_guard<py::gil_scoped_release>())
      .def("step", &LockStepCell::step, py::call_guard<py::gil_scoped_release>())
      .def("ask", &LockStepCell::ask, py::call_guard<py::gil_scoped_release>())
      .def("states", &LockStepCell::states)
      .def("commands", &LockStepCell::commands)
      .def("take_events",
           [](LockStepCell& cell) {
             py::list out;
             for (const Event& event : cell.take_events())
               out.append(py::make_tuple(event.time, event.kind, event.text, event.where));
             return out;
           })
      .def_property_readonly("state_names", &LockStepCell::state_names)
      .def_property_readonly("command_names", &LockStepCell::command_names)
      .def_property_readonly("time", &LockStepCell::time)
      .def_property_readonly("period", &LockStepCell::period)
      .def_property_readonly("loop_state", &LockStepCell::loop_state)
      .def_property_readonly("finished", &LockStepCell::finished)
      .def_property_readonly("failure", &LockStepCell::failure);
}

}  // namespace polyarm::python
