#include "polyarm/doctor/trial.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/error.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::doctor {

namespace {

using hardware::CallbackReturn;
using hardware::Component;
using hardware::ReturnType;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// One component in its own loop.
class Loop {
 public:
  Loop(Component& component, const TrialOptions& options, Trial& trial)
      : component_(component), options_(options), trial_(trial), clock_(nanoseconds(1 / options.rate)) {
    cycle_.period = nanoseconds(1 / options.rate);
    for (const auto& state : component.state_interfaces()) {
      trial.states.push_back({state.name, kUnknown, kUnknown, kUnknown, kUnknown});
      values_.push_back(state.initial);
    }
    before_ = values_;
    for (const auto& command : component.command_interfaces()) commands_.push_back(command.name);
    written_.assign(commands_.size(), kUnknown);
    clock_.start();
    begun_ = news_ = realtime::monotonic_now();
  }

  /// One cycle; false if it failed or must end.
  bool step(bool writing) {
    if (options_.stop()) {
      trial_.stopped = true;
      return false;
    }
    trial_.late += clock_.wait().skipped > 0;
    cycle_.time += cycle_.period;
    ++cycle_.index;
    Nanoseconds from = realtime::monotonic_now();
    if (component_.read(cycle_, values_) != ReturnType::ok) return fail("reading failed");
    read_.add(realtime::monotonic_now() - from);
    ++trial_.reads;
    look();
    if (!writing) return true;
    from = realtime::monotonic_now();
    if (component_.write(cycle_, written_) != ReturnType::ok) return fail("writing failed");
    write_.add(realtime::monotonic_now() - from);
    return true;
  }

  /// A small move there and back; the velocity is zero at both ends.
  bool move(std::size_t command, double distance) {
    const double start = value_of(commands_[command]);
    if (!std::isfinite(start)) return fail(commands_[command] + " cannot be moved: its position is unknown");
    const auto cycles = static_cast<int>(2 * options_.rate);
    for (int k = 0; k <= cycles; ++k) {
      written_[command] = start + distance * 0.5 * (1 - std::cos(2 * M_PI * k / cycles));
      if (!step(true)) return false;
    }
    trial_.moved = true;
    return true;
  }

  std::vector<std::size_t> movable() const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < commands_.size(); ++i)
      if (commands_[i].ends_with("/position")) out.push_back(i);
    return out;
  }
  std::size_t cycles() const { return static_cast<std::size_t>(options_.seconds * options_.rate); }
  const std::vector<std::string>& commands() const { return commands_; }

  void finish() {
    const auto us = [](Nanoseconds t) { return static_cast<double>(t) * 1e-3; };
    trial_.read_us_p50 = us(read_.percentile(0.5));
    trial_.read_us_p99 = us(read_.percentile(0.99));
    trial_.read_us_max = us(read_.max());
    trial_.write_us_p99 = us(write_.percentile(0.99));
    trial_.gap_ms_p50 = us(gaps_.percentile(0.5)) * 1e-3;
    trial_.gap_ms_p99 = us(gaps_.percentile(0.99)) * 1e-3;
    trial_.gap_ms_max = us(gaps_.max()) * 1e-3;
    const double duration = std::max(1e-9, seconds(realtime::monotonic_now() - begun_));
    for (TriedState& state : trial_.states) {
      state.changes_per_second /= duration;
      if (trial_.reads > 0) state.finite /= static_cast<double>(trial_.reads);
    }
  }

 private:
  bool fail(std::string what) {
    trial_.failure = std::move(what);
    return false;
  }
  double value_of(const std::string& name) const {
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (trial_.states[i].name == name) return values_[i];
    return kUnknown;
  }
  void look() {
    bool news = false;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      TriedState& state = trial_.states[i];
      const double now = values_[i];
      if (!std::isfinite(now)) continue;
      ++state.finite;
      if (std::isfinite(before_[i]) && now != before_[i]) {
        ++state.changes_per_second;
        news = true;
      }
      if (std::isnan(state.first)) state.first = state.least = state.most = now;
      state.last = now;
      state.least = std::min(state.least, now);
      state.most = std::max(state.most, now);
    }
    before_ = values_;
    if (!news) return;
    const Nanoseconds now = realtime::monotonic_now();
    gaps_.add(now - news_);
    news_ = now;
  }

  Component& component_;
  const TrialOptions& options_;
  Trial& trial_;
  realtime::Periodic clock_;
  hardware::Cycle cycle_;
  std::vector<std::string> commands_;
  std::vector<double> values_, before_, written_;
  realtime::Histogram read_, write_, gaps_;
  Nanoseconds begun_ = 0, news_ = 0;
};

bool walk(Loop& loop, const TrialOptions& options) {
  for (std::size_t k = 0; k < loop.cycles(); ++k)
    if (!loop.step(false)) return false;
  if (options.move)
    for (const std::size_t command : loop.movable())
      if (!loop.move(command, options.distance)) return false;
  return true;
}

bool succeeds(Component& component, CallbackReturn result, const char* step, Trial& trial) {
  if (result == CallbackReturn::success) return true;
  const std::string reason = component.reason();
  trial.failure = std::string(step) + " failed" + (reason.empty() ? "" : ": " + reason);
  return false;
}

void run(Component& component, const TrialOptions& options, Trial& trial) {
  const Nanoseconds from = realtime::monotonic_now();
  const bool configured = succeeds(component, component.on_configure(), "opening", trial);
  trial.configure_ms = seconds(realtime::monotonic_now() - from) * 1e3;
  if (!configured) return;
  trial.summary = component.summary();
  const bool activate = options.move || !component.real();
  if (activate && !succeeds(component, component.on_activate(), "activating", trial)) {
    component.on_shutdown();
    return;
  }
  Loop loop(component, options, trial);
  std::vector<std::string> positions;
  for (const std::size_t i : loop.movable()) positions.push_back(loop.commands()[i]);
  bool fine = !options.move || positions.empty() ||
              (component.prepare_command_mode_switch(positions, {}) == ReturnType::ok &&
               component.perform_command_mode_switch(positions, {}) == ReturnType::ok);
  if (!fine) trial.failure = "the joints do not take positions";
  fine = fine && walk(loop, options);
  loop.finish();
  trial.reason = component.reason();
  if (!fine && !trial.failure.empty()) {
    if (!trial.reason.empty()) trial.failure += ": " + trial.reason;
    component.on_error();
  } else if (activate) {
    fine = succeeds(component, component.on_deactivate(), "deactivating", trial) && fine;
  }
  component.on_shutdown();
  trial.passed = fine;
}

bool ends(const std::string& name, const char* with) {
  return name.ends_with(std::string("/") + with);
}

YAML::Emitter& number(YAML::Emitter& out, const char* key, double value) {
  out << YAML::Key << key << YAML::Value;
  if (std::isfinite(value))
    out << fmt::format("{:g}", value);
  else
    out << YAML::Null;
  return out;
}

void emit_state(YAML::Emitter& out, const TriedState& state) {
  out << YAML::Flow << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted
      << state.name;
  number(out, "first", state.first), number(out, "last", state.last);
  number(out, "least", state.least), number(out, "most", state.most);
  number(out, "known", state.finite), number(out, "changes_per_second", state.changes_per_second);
  out << YAML::EndMap;
}

void text(YAML::Emitter& out, const char* key, const std::string& value) {
  out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << value;
}

}  // namespace

Trial try_driver(Component& component, const hardware::ComponentContext& context,
                 const TrialOptions& options) {
  Trial trial;
  trial.driver = context.name;
  trial.parameters = context.parameters;
  try {
    if (succeeds(component, component.on_init(context), "reading the parameters", trial))
      run(component, options, trial);
  } catch (const std::exception& e) {
    trial.failure = e.what();
  }
  return trial;
}

std::vector<std::string> highlights(const Trial& trial) {
  std::vector<std::string> out;
  if (trial.reads == 0) return out;
  out.push_back(fmt::format("opened and identified in {:.0f} ms; {} reads, {} of them late",
                            trial.configure_ms, trial.reads, trial.late));
  out.push_back(fmt::format("a read took {:.0f} us (half), {:.0f} us (99 %), {:.0f} us (most)",
                            trial.read_us_p50, trial.read_us_p99, trial.read_us_max));
  out.push_back(fmt::format("new values every {:.1f} ms (half), {:.1f} ms (99 %), {:.1f} ms (most)",
                            trial.gap_ms_p50, trial.gap_ms_p99, trial.gap_ms_max));
  for (const TriedState& s : trial.states) {
    if (ends(s.name, "bad_frames") || ends(s.name, "lost_bytes"))
      out.push_back(fmt::format("{}: {:g} while it was read, {:g} since it was opened", s.name,
                                s.last - s.first, s.last));
    else if (ends(s.name, "frames"))
      out.push_back(fmt::format("{}: {:g} while it was read", s.name, s.last - s.first));
    else if (s.name.find("temperature") != std::string::npos || s.name.find("voltage") != std::string::npos ||
             s.name.find("current") != std::string::npos)
      out.push_back(fmt::format("{}: {:g}, from {:g} to {:g}", s.name, s.last, s.least, s.most));
  }
  for (const TriedState& s : trial.states)
    if (s.finite < 1)
      out.push_back(fmt::format("{}: known in {:.0f} % of the reads", s.name, 100 * s.finite));
  return out;
}

std::string report(const Trial& trial, const TrialSetting& setting) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  text(out, "polyarm", "driver-report/1");
  text(out, "version", setting.version), text(out, "time", setting.time), text(out, "kernel", setting.kernel);
  out << YAML::Key << "preempt_rt" << YAML::Value << setting.preempt_rt;
  text(out, "driver", trial.driver), text(out, "proof_so_far", setting.proof);
  out << YAML::Key << "parameters" << YAML::Value << YAML::BeginMap;
  for (const auto& [name, value] : trial.parameters) text(out, name.c_str(), value);
  out << YAML::EndMap;
  text(out, "result", trial.passed ? "passed" : trial.stopped ? "stopped by a person" : "failed");
  text(out, "failure", trial.failure), text(out, "device", trial.summary),
      text(out, "complaint", trial.reason);
  out << YAML::Key << "moved" << YAML::Value << trial.moved;
  number(out, "configure_ms", trial.configure_ms), number(out, "reads", static_cast<double>(trial.reads));
  number(out, "late", static_cast<double>(trial.late));
  for (const auto& [key, p50, p99, most] :
       {std::tuple{"read_us", trial.read_us_p50, trial.read_us_p99, trial.read_us_max},
        std::tuple{"news_gap_ms", trial.gap_ms_p50, trial.gap_ms_p99, trial.gap_ms_max}}) {
    out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginMap;
    number(out, "p50", p50), number(out, "p99", p99), number(out, "max", most);
    out << YAML::EndMap;
  }
  number(out, "write_us_p99", trial.write_us_p99);
  out << YAML::Key << "states" << YAML::Value << YAML::BeginSeq;
  for (const TriedState& state : trial.states) emit_state(out, state);
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace polyarm::doctor
