#pragma once
/// Work that takes longer than a tick: steps that are polled on the cell thread, and jobs for another thread.
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/io/worker.hpp"

namespace polyarm::cell {

/// Progress of a step: no answer yet, an answer with more to follow, or the last answer.
template <class Answer>
struct Progress {
  std::optional<Answer> answer;
  bool over = false;
  static Progress done(Answer answer) { return {std::move(answer), true}; }
  static Progress more(Answer answer) { return {std::move(answer), false}; }
};
/// Called once each tick until `over`; may throw Error, which ends it.
template <class Answer>
using Poll = std::function<Progress<Answer>()>;
/// Answer of a step without an answer of its own.
struct Done {};

template <class Answer>
Poll<Answer> at_once(Answer answer) {
  return [answer = std::move(answer)] { return Progress<Answer>::done(answer); };
}

/// Runs two steps in sequence: `second` takes the answer of the first and returns a Poll.
template <class First, class Second>
auto then(Poll<First> first, Second second) {
  using Next = std::invoke_result_t<Second, First>;
  using Answer = typename decltype(std::declval<Next>()().answer)::value_type;
  return Next([first = std::move(first), second = std::move(second), next = Next{}]() mutable {
    if (next) return next();
    Progress<First> progress = first();
    if (!progress.over) return Progress<Answer>{};
    next = second(progress.answer ? std::move(*progress.answer) : First{});
    return next();
  });
}

/// A job for another thread, and the Poll on the cell thread that ends when the job is done.
template <class Answer>
struct Errand {
  std::function<void()> run;  ///< call once, on the other thread; does not throw
  Poll<Answer> done;
};

/// Runs `job` on another thread (it must not touch the cell), then `finish` on the cell thread, which makes
/// the answer from the job's result. An Error of the job is rethrown by the Poll.
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

/// Posts an errand to the cell's worker.
template <class Job, class Finish>
auto later(Worker& worker, Job job, Finish finish) {
  auto sent = errand(std::move(job), std::move(finish));
  worker.post(std::move(sent.run));
  return std::move(sent.done);
}
/// The same; the job's result is the answer.
template <class Job>
auto later(Worker& worker, Job job) {
  return later(worker, std::move(job), [](auto& result) { return std::move(result); });
}

}  // namespace polyarm::cell
