#pragma once
/// Requests that touch the disk or plan: on the cell's worker, and on the cell thread again with what came
/// out. Private to the room.
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

/// A job for some other thread, and what asks on the cell thread whether it has been done.
struct Errand {
  std::function<void()> run;  ///< on the other thread, once; throws nothing
  Poll done;
};

/// `job` (it must not touch the cell) for another thread and then `finish` on the cell thread; an Error of
/// the job becomes the request's.
template <typename Result>
Errand errand(std::function<Result()> job, std::function<Json(Cell&, Result&)> finish) {
  struct State {
    std::atomic<bool> done{false};
    std::optional<Result> result;
    std::optional<Error> error;
  };
  auto state = std::make_shared<State>();
  auto run = [state, job = std::move(job)] {
    try {
      state->result = job();
    } catch (const Error& e) {
      state->error = e;
    } catch (...) {
      state->error = Error("internal", "unexpected: " + what_was_thrown());
    }
    state->done.store(true, std::memory_order_release);
  };
  auto done = [state, finish = std::move(finish)](Cell& c) {
    if (!state->done.load(std::memory_order_acquire)) return Progress{};
    if (state->error) throw *state->error;
    return Progress::done(finish(c, *state->result));
  };
  return {std::move(run), std::move(done)};
}

/// An errand of the cell's worker.
template <typename Result>
Poll later(Cell& cell, std::function<Result()> job, std::function<Json(Cell&, Result&)> finish) {
  Errand sent = errand<Result>(std::move(job), std::move(finish));
  cell.worker().post(std::move(sent.run));
  return std::move(sent.done);
}

/// A file of the project by its path in the cell's folder. Throws Error("bad-path") for one that would lead
/// out of it, is hidden, or is of no kind that a project has.
std::filesystem::path project_file(const std::filesystem::path& folder, const std::string& path);
/// 16 hexadecimal digits that tell contents apart; not for security.
std::string content_hash(std::string_view text);

}  // namespace polyarm::cell
