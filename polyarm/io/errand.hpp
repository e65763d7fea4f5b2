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

/// What a task has come to: nothing yet, an answer that is followed by more, or the last one.
template <class Answer>
struct Progress {
  std::optional<Answer> answer;
  bool over = false;
  static Progress done(Answer answer) { return {std::move(answer), true}; }
  static Progress more(Answer answer) { return {std::move(answer), false}; }
};
/// Called once each tick until it is over; may throw Error, which ends it.
template <class Answer>
using Poll = std::function<Progress<Answer>()>;
/// Of a step that has no answer of its own.
struct Done {};

template <class Answer>
Poll<Answer> at_once(Answer answer) {
  return [answer = std::move(answer)] { return Progress<Answer>::done(answer); };
}

/// Two steps one after the other: `second` takes what the first answered and returns a Poll.
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

}  // namespace polyarm::cell
