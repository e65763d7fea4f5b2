#pragma once
/// How a request is dispatched to its handler function. For files that implement requests; cell thread.
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "polyarm/inside/inside.hpp"
#include "polyarm/io/errand.hpp"
#include "polyarm/protocol/request.hpp"

namespace polyarm::cell {

using AnyProgress = Progress<protocol::Answer>;
using AnyPoll = Poll<protocol::Answer>;

/// A request type and the function that begins it; the function may throw Error.
struct Handler {
  const protocol::RequestType* type;
  AnyPoll (*begin)(CellInside&, const protocol::Request&);
};

/// Converts to a reference to any owner of the cell.
struct AnyOwner {
  CellInside& inside;
  template <class Owner>
  operator Owner&() const {
    return inside.owner<Owner>();
  }
};
/// Builds a struct of references to owners; each member is found by its type. The number of members is found
/// by trying.
template <class Owners, std::size_t... kMembers>
Owners owners_of(CellInside& inside, std::index_sequence<kMembers...>) {
  const AnyOwner owner{inside};
  if constexpr (requires { Owners{(static_cast<void>(kMembers), owner)...}; }) {
    return Owners{(static_cast<void>(kMembers), owner)...};
  } else {
    static_assert(sizeof...(kMembers) < 16, "a struct of references to the cell's owners");
    return owners_of<Owners>(inside, std::make_index_sequence<sizeof...(kMembers) + 1>());
  }
}
template <class Owners>
Owners owners_of(CellInside& inside) {
  if constexpr (std::is_empty_v<Owners>)
    return {};
  else
    return owners_of<Owners>(inside, std::make_index_sequence<1>());
}

template <auto kFunction>
struct HandlerOf;
/// A handler function takes a struct of references to the owners that it needs (copy the struct into a
/// returned Poll) and the request's struct. It returns the answer, or a Poll that yields it later.
template <class Owners, class R, class Result, Result (*kFunction)(const Owners&, const R&)>
struct HandlerOf<kFunction> {
  using Answer = typename R::Answer;
  static AnyPoll begin(CellInside& inside, const protocol::Request& request) {
    const Owners owners = owners_of<Owners>(inside);
    if constexpr (std::is_same_v<Result, Answer>) {
      return at_once(protocol::Answer::of<R>(kFunction(owners, request.as<R>())));
    } else {
      return [poll = kFunction(owners, request.as<R>())]() mutable {
        Progress<Answer> progress = poll();
        if (!progress.answer) return AnyProgress{{}, progress.over};
        return AnyProgress{protocol::Answer::of<R>(std::move(*progress.answer)), progress.over};
      };
    }
  }
  static Handler handler() { return {&protocol::request_type<R>(), begin}; }
};
template <auto... kFunctions>
std::vector<Handler> handlers() {
  return {HandlerOf<kFunctions>::handler()...};
}

/// The index of the robot with this name. Without a name: the only robot. Throws Error("which-robot" |
/// "unknown-robot").
std::size_t robot_named(const CellSetup& setup, const std::optional<std::string>& name);
/// Parses a life-cycle state. Throws Error("bad-argument").
hardware::LifecycleState state_named(const std::string& word);
/// The state of the controller with this name. Throws Error("unknown-controller").
hardware::LifecycleState controller_state(const Machine& machine, const std::string& name);
/// Update rate of the component or the controller, Hz.
double rate_of(const Machine& machine, const hardware::HostedInfo& info);
double rate_of(const Machine& machine, const control::ListedController& controller);

}  // namespace polyarm::cell
