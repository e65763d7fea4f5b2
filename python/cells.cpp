/// A simulated cell that a Python program steps. A turn lets one thread at a time see the cell, also while it
/// is built anew. Every function waits for its turn without the lock of the interpreter, and ends it before
/// it needs that lock again: neither is ever waited for under the other.
#include <pybind11/stl.h>

#include <condition_variable>
#include <cstdint>
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

/// The first `count` values, copied.
auto first(const auto& values, std::size_t count) {
  return std::vector(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
}

/// A mutex that threads get in the order in which they asked, so that one that steps on and on lets others
/// read.
class Turn {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    const std::uint64_t mine = next_++;
    changed_.wait(lock, [&] { return mine == now_; });
  }
  void unlock() {
    {
      const std::lock_guard lock(mutex_);
      ++now_;
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t next_ = 0, now_ = 0;
};

class LockStepCell {
 public:
  LockStepCell(const std::string& path, cell::Overrides overrides, cell::CellOptions options)
      : path_(path), overrides_(std::move(overrides)), options_(std::move(options)) {
    options_.lock_step = true;
    build();
  }
  ~LockStepCell() { end(); }

  void reset() {
    const std::lock_guard lock(turn_);
    end();
    listener_ = {};
    build();
  }

  /// `cycles` of the control loop; a tick of the cell before each cycle that needs one.
  void step(std::size_t cycles) {
    const std::lock_guard lock(turn_);
    for (std::size_t i = 0; i < cycles; ++i) step_once();
  }

  /// The answer to a request, as JSON. Time goes on until it is there, at most `patience` s of cell time.
  /// `follow`: to the last of several answers.
  std::string ask(const std::string& request, const std::string& id, bool follow, double patience) {
    const std::lock_guard lock(turn_);
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

  double time() const {
    const std::lock_guard lock(turn_);
    return seconds(loop().cycle().time);
  }
  double period() const {
    const std::lock_guard lock(turn_);
    return seconds(loop().options().period);
  }
  std::vector<std::string> state_names() const {
    const std::lock_guard lock(turn_);
    return first(table().state_names(), table().built_states());
  }
  std::vector<std::string> command_names() const {
    const std::lock_guard lock(turn_);
    return first(table().command_names(), table().built_commands());
  }
  std::vector<double> states() const {
    const std::lock_guard lock(turn_);
    return first(table().states(), table().built_states());
  }
  std::vector<double> commands() const {
    const std::lock_guard lock(turn_);
    return first(table().commands(), table().built_commands());
  }
  std::vector<Event> take_events() {
    const std::lock_guard lock(turn_);
    return listener_.take();
  }
  std::string loop_state() const {
    const std::lock_guard lock(turn_);
    return control::name(loop().supervisor().state());
  }
  bool finished() const {
    const std::lock_guard lock(turn_);
    return inside().life->finished();
  }
  /// Why the cell cannot go on: code and text; empty while it can.
  std::pair<std::string, std::string> failure() const {
    const std::lock_guard lock(turn_);
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

  std::string path_;
  cell::Overrides overrides_;
  cell::CellOptions options_;
  Listener listener_;
  std::unique_ptr<cell::Cell> cell_;
  Nanoseconds next_tick_ = 0;
  mutable Turn turn_;
};

/// Calls a const member of the cell without the lock of the interpreter; the result becomes a Python object
/// after that.
template <auto kMember>
auto unlocked(const LockStepCell& cell) {
  const py::gil_scoped_release others;
  return (cell.*kMember)();
}

template <auto kMember>
Numbers unlocked_array(const LockStepCell& cell) {
  const std::vector<double> values = unlocked<kMember>(cell);
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}
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
      .def("states", &unlocked_array<&LockStepCell::states>)
      .def("commands", &unlocked_array<&LockStepCell::commands>)
      .def("take_events",
           [](LockStepCell& cell) {
             std::vector<Event> events;
             {
               const py::gil_scoped_release others;
               events = cell.take_events();
             }
             py::list out;
             for (const Event& event : events)
               out.append(py::make_tuple(event.time, event.kind, event.text, event.where));
             return out;
           })
      .def_property_readonly("state_names", &unlocked<&LockStepCell::state_names>)
      .def_property_readonly("command_names", &unlocked<&LockStepCell::command_names>)
      .def_property_readonly("time", &unlocked<&LockStepCell::time>)
      .def_property_readonly("period", &unlocked<&LockStepCell::period>)
      .def_property_readonly("loop_state", &unlocked<&LockStepCell::loop_state>)
      .def_property_readonly("finished", &unlocked<&LockStepCell::finished>)
      .def_property_readonly("failure", &unlocked<&LockStepCell::failure>);
}

}  // namespace polyarm::python
