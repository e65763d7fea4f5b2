#pragma once
/// Requests that touch the disk or plan: on the cell's worker, and then on the cell thread with the result. Private to
/// the room.
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

/// A job for another thread, and the poll on the cell thread that ends when it has been done.
template <class Answer>
struct Errand {
  std::function<void()> run;  ///< on the other thread, once; throws nothing
  Poll<Answer> done;
};

/// `job` (it must not touch the cell) for another thread and then `finish`, from its result to the answer, on the cell
/// thread; an Error of the job becomes the request's.
template <class Job, class Finish>
auto errand(Job job, Finish finish) {
  using Result = std::invoke_result_t<Job>;
  using Answer = std::invoke_result_t<Finish, Result&>;
  struct State {
    std::atomic<bool> done{false};
    std::optional<Result> result;
    std::optional<Error> error;
  };
  auto state = std::make_shared<State>();
  auto run = [state, job = std::move(job)]() mutable {
    try {
      state->result = job();
    } catch (...) {
      state->error = error_thrown();
    }
    state->done.store(true, std::memory_order_release);
  };
  auto done = [state, finish = std::move(finish)]() mutable {
    if (!state->done.load(std::memory_order_acquire)) return Progress<Answer>{};
    if (state->error) throw *state->error;
    return Progress<Answer>::done(finish(*state->result));
  };
  return Errand<Answer>{std::move(run), std::move(done)};
}

/// An errand of the cell's worker.
template <class Job, class Finish>
auto later(Worker& worker, Job job, Finish finish) {
  auto sent = errand(std::move(job), std::move(finish));
  worker.post(std::move(sent.run));
  return std::move(sent.done);
}
/// The same; what the job returns is the answer.
template <class Job>
auto later(Worker& worker, Job job) {
  return later(worker, std::move(job), [](auto& result) { return std::move(result); });
}

/// A file of the project by its path in the cell's folder. Throws Error("bad-path") for one that would lead
/// out of it, is hidden, or is of no kind that a project has.
std::filesystem::path project_file(const std::filesystem::path& folder, const std::string& path);
/// 16 hexadecimal digits that tell contents apart; not for security.
std::string content_hash(std::string_view text);

}  // namespace polyarm::cell
