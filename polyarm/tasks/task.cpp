#include "polyarm/tasks/task.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

using program::TaskState;

Task::Task(std::string name, program::Program program, ProgramHost::Context context,
           std::optional<std::size_t> test)
    : name_(std::move(name)),
      observer_(context.observer),
      now_(context.now),
      host_(std::move(context)),
      interpreter_(std::move(program), host_, test) {
  interpreter_.on_wait_over([this] { look(); });
  look();
}

void Task::look() {
  std::swap(status_, before_);
  interpreter_.overview(status_);
  const std::uint64_t cycles = before_.cycles;
  if (status_.waiting.kind != before_.waiting.kind || status_.waiting.names != before_.waiting.names) {
    waits_since_.reset();
    if (status_.waiting.kind != program::WaitKind::none) waits_since_ = *now_;
  }
  seen_ = interpreter_.position();
  if (status_.cycles > cycles) {
    const auto more = static_cast<Nanoseconds>(status_.cycles - cycles);
    if (pass_ended_) last_pass_ = (*now_ - *pass_ended_) / more;
    pass_ended_ = *now_;
  }
  const bool same = status_.where.line == shown_.line && status_.where.file == shown_.file;
  if (same || status_.state == TaskState::finished) return;
  shown_ = status_.where;
  observer_->on_line(*now_, name_, status_.where, status_.source);
}

void Task::tick() {
  tick({});
}

void Task::tick(const std::function<void()>& between) {
  if (ended()) return;
  int done = 0;
  while (done < kBudget) {
    const program::StepResult result = interpreter_.step(done < kReported ? 1 : kBudget - done);
    const bool news = result.state != status_.state || interpreter_.paused() != status_.paused;
    if (result.executed > 0 || news) look();
    if (result.executed == 0) break;
    done += result.executed;
    if (between) between();
  }
  if (done < kBudget)
    busy_since_.reset();
  else if (!busy_since_)
    busy_since_ = *now_;
  // Moves run while no statement begins.
  const program::Place at = interpreter_.position();
  if (at.line != seen_.line || at.file != seen_.file || interpreter_.cycles() != status_.cycles) look();
}

bool Task::ended() const {
  return status_.state != TaskState::running && status_.state != TaskState::waiting;
}

namespace {
std::string sentence_of(const program::TaskStatus& status) {
  std::string out = fmt::format("{}: {}", status.where.text(), status.source);
  switch (status.waiting.kind) {
    case program::WaitKind::condition:
      out += ", waits for " +
             (status.waiting.names.empty() ? std::string("a condition") : join(status.waiting.names, ", "));
      break;
    case program::WaitKind::move:
      out += ", moves to " + status.waiting.text;
      break;
    case program::WaitKind::user:
      out += ", waits for a person";
      break;
    case program::WaitKind::load:
      out += ", loads " + status.waiting.text;
      break;
    case program::WaitKind::time:
      out += ", waits for time to pass";
      break;
    case program::WaitKind::arrival:
    case program::WaitKind::room:
      out += ", moves";
      break;
    case program::WaitKind::until:
      out += ", moves until " + join(status.waiting.names, ", ");
      break;
    case program::WaitKind::meet:
    case program::WaitKind::lock:
      out += ", waits for another task at " + status.waiting.text;
      break;
    case program::WaitKind::together:
      out += ", waits for what it does together";
      break;
    case program::WaitKind::turn:
    case program::WaitKind::none:
      break;
  }
  return out;
}
}  // namespace

std::string Task::sentence() const {
  return sentence_of(status_);
}

std::string Task::sentences() const {
  std::vector<std::string> out;
  for (const program::TaskStatus& task : interpreter_.status())
    if (task.state == program::TaskState::running || task.state == program::TaskState::waiting)
      out.push_back(sentence_of(task));
  return out.empty() ? sentence() : join(out, "; ");
}

}  // namespace polyarm::cell
