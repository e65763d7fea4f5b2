#include "polyarm/control/switch_plan.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <queue>
#include <set>
#include <string_view>
#include <unordered_map>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::control {

using hardware::LifecycleState;

namespace {

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool shares(const std::vector<std::string>& wanted, const std::vector<std::string>& offered) {
  return std::any_of(wanted.begin(), wanted.end(),
                     [&](const std::string& w) { return contains(offered, w); });
}

/// True if `a` must be updated before `b`: it writes b's references, or b reads a state that it exports.
bool comes_before(const ControllerView& a, const ControllerView& b) {
  return (!b.references.empty() && shares(a.commands, b.references)) ||
         (!a.exported.empty() && shares(b.states, a.exported));
}

/// Why a controller is refused.
struct Refusal {
  std::string code, reason, advice;
};

class Planner {
 public:
  Planner(std::span<const ControllerView> controllers, const SwitchRequest& request,
          const Unavailable& unavailable)
      : all_(controllers), request_(request), unavailable_(unavailable) {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      for (const std::string& name : all_[i].commands) claiming_[name].push_back(i);
      for (const std::string& name : all_[i].references) offering_[name].push_back(i);
      for (const std::string& name : all_[i].exported) exporting_[name].push_back(i);
    }
  }

  SwitchPlan plan() {
    for (const std::string& name : request_.deactivate) take(name, false);
    for (const std::string& name : request_.activate) take(name, true);
    if (automatic()) close_over_chains();
    // Removing one controller may break the chain of another; repeat until nothing changes.
    for (bool again = plan_.ok; again && plan_.ok;) again = drop_impossible();
    if (plan_.ok) finish();
    if (!plan_.ok) {
      SwitchPlan refused;
      refused.ok = false;
      refused.code = plan_.code;
      refused.reason = plan_.reason;
      refused.advice = plan_.advice;
      return refused;
    }
    return std::move(plan_);
  }

 private:
  bool best_effort() const { return request_.strictness == Strictness::best_effort; }
  bool automatic() const {
    return request_.strictness == Strictness::automatic || request_.strictness == Strictness::force;
  }

  const ControllerView* find(const std::string& name) const {
    for (const ControllerView& c : all_)
      if (c.name == name) return &c;
    return nullptr;
  }

  void refuse(Refusal refusal) {
    if (best_effort()) {
      plan_.left_out.push_back(refusal.reason);
      return;
    }
    if (!plan_.ok) return;
    plan_.ok = false;
    plan_.code = std::move(refusal.code);
    plan_.reason = std::move(refusal.reason);
    plan_.advice = std::move(refusal.advice);
  }

  void take(const std::string& name, bool activate) {
    const ControllerView* c = find(name);
    if (!c) {
      std::vector<std::string> known;
      for (const ControllerView& other : all_) known.push_back(other.name);
      return refuse({"unknown-controller",
                     "there is no controller '" + name + "'" + did_you_mean(name, known), "load it first"});
    }
    if (activate && contains(request_.deactivate, name)) return starting_.insert(name), void();  // a restart
    if (activate && c->state == LifecycleState::active)
      return refuse({"already-active", "the controller '" + name + "' is active already", "leave it out"});
    if (activate && c->state != LifecycleState::inactive)
      return refuse({"not-configured",
                     "the controller '" + name + "' is " + hardware::name(c->state) + ", not inactive",
                     "configure it first"});
    if (!activate && c->state != LifecycleState::active)
      return refuse({"not-active",
                     "the controller '" + name + "' is " + hardware::name(c->state) + ", not active",
                     "leave it out"});
    (activate ? starting_ : stopping_).insert(name);
  }

  bool active_after(const ControllerView& c) const {
    if (starting_.contains(c.name)) return true;
    return c.state == LifecycleState::active && !stopping_.contains(c.name);
  }

  /// Starts what chains need, stops what depends on stopped controllers, and with `force` also controllers
  /// that claim the same interface.
  void close_over_chains() {
    for (bool again = true; again;) {
      again = false;
      for (const ControllerView& c : all_) {
        if (!starting_.contains(c.name)) continue;
        for (const ControllerView& other : all_) {
          const bool needed = other.name != c.name &&
                              (shares(c.commands, other.references) || shares(c.states, other.exported));
          if (needed && !active_after(other) && other.state == LifecycleState::inactive &&
              !stopping_.contains(other.name)) {
            starting_.insert(other.name);
            again = true;
          }
          const bool in_the_way = other.name != c.name && other.state == LifecycleState::active &&
                                  shares(c.commands, other.commands) && !stopping_.contains(other.name);
          if (in_the_way && request_.strictness == Strictness::force && !starting_.contains(other.name)) {
            stopping_.insert(other.name);
            again = true;
          }
        }
      }
      for (const ControllerView& c : all_) {
        if (c.state != LifecycleState::active || stopping_.contains(c.name) || starting_.contains(c.name))
          continue;
        for (const ControllerView& other : all_)
          if (stopping_.contains(other.name) && !starting_.contains(other.name) &&
              (shares(c.commands, other.references) || shares(c.states, other.exported))) {
            stopping_.insert(c.name);
            again = true;
            break;
          }
      }
    }
  }

  /// Removes one impossible request, or refuses the switch. False if all remaining requests are possible.
  bool drop_impossible() {
    for (const ControllerView& c : all_)
      if (starting_.contains(c.name))
        if (auto refusal = why_not_start(c)) {
          starting_.erase(c.name);
          refuse(std::move(*refusal));
          return true;
        }
    for (const ControllerView& c : all_)
      if (stopping_.contains(c.name) && !starting_.contains(c.name))
        if (auto refusal = why_not_stop(c)) {
          stopping_.erase(c.name);
          refuse(std::move(*refusal));
          return true;
        }
    return false;
  }

  std::ptrdiff_t rank(const std::string& name) const {
    return std::find(request_.activate.begin(), request_.activate.end(), name) - request_.activate.begin();
  }

  std::optional<Refusal> why_not_start(const ControllerView& c) const {
    for (const auto& [names, command] : {std::pair{&c.commands, true}, std::pair{&c.states, false}})
      for (const std::string& name : *names)
        if (const std::string why = unavailable_(name, command); !why.empty())
          return Refusal{"hardware-inactive",
                         "the controller '" + c.name + "' needs '" + name + "', but " + why,
                         "activate the hardware component first"};
    for (const std::size_t i : concerned_by(c)) {
      const ControllerView& other = all_[i];
      if (other.name == c.name) continue;
      // If two starting controllers claim the same interface, the later one is refused.
      if (active_after(other) && !(starting_.contains(other.name) && rank(other.name) > rank(c.name)))
        for (const std::string& name : c.commands)
          if (contains(other.commands, name))
            return Refusal{"claimed",
                           "the controller '" + c.name + "' needs '" + name + "', which the " +
                               (starting_.contains(other.name) ? "controller '" : "active controller '") +
                               other.name + "' holds" + (starting_.contains(other.name) ? " too" : ""),
                           "deactivate that one in the same switch"};
      if (!active_after(other) && (shares(c.commands, other.references) || shares(c.states, other.exported)))
        return Refusal{
            "chain-missing",
            "the controller '" + c.name + "' works through '" + other.name + "', which is not active",
            "activate '" + other.name + "' in the same switch, or let it be done automatically"};
    }
    return std::nullopt;
  }

  /// Controllers that claim the same commands, and those that offer interfaces used by `c`.
  std::set<std::size_t> concerned_by(const ControllerView& c) const {
    std::set<std::size_t> out;
    const auto add = [&](const Places& places, const std::string& name) {
      const auto found = places.find(name);
      if (found != places.end()) out.insert(found->second.begin(), found->second.end());
    };
    for (const std::string& name : c.commands) add(claiming_, name), add(offering_, name);
    for (const std::string& name : c.states) add(exporting_, name);
    return out;
  }

  std::optional<Refusal> why_not_stop(const ControllerView& c) const {
    if (c.references.empty() && c.exported.empty()) return std::nullopt;
    for (const ControllerView& other : all_)
      if (other.name != c.name && active_after(other) &&
          (shares(other.commands, c.references) || shares(other.states, c.exported)))
        return Refusal{"chain-in-use",
                       "the controller '" + c.name + "' cannot stop: '" + other.name + "' works through it",
                       "deactivate '" + other.name + "' in the same switch"};
    return std::nullopt;
  }

  void finish() {
    std::vector<std::size_t> order;
    try {
      order = update_order(all_);
    } catch (const Error& e) {
      return refuse({"chain-circle", e.problems().front().what, {}});
    }
    for (const std::size_t i : order)
      if (stopping_.contains(all_[i].name)) plan_.stop.push_back(all_[i].name);
    for (auto i = order.rbegin(); i != order.rend(); ++i)
      if (starting_.contains(all_[*i].name)) plan_.start.push_back(all_[*i].name);
    for (const ControllerView& c : all_) chains_of(c);
    for (const ControllerView& c : all_) {
      if (starting_.contains(c.name)) add_hardware(c, plan_.start_interfaces);
      if (stopping_.contains(c.name)) add_hardware(c, plan_.stop_interfaces);
    }
  }

  void chains_of(const ControllerView& c) {
    if (c.references.empty()) return;
    bool before = false, after = false;
    for (const ControllerView& other : all_) {
      if (!shares(other.commands, c.references)) continue;
      before = before || other.state == LifecycleState::active;
      after = after || active_after(other);
    }
    if (!active_after(c)) return;
    if (after && (!before || starting_.contains(c.name))) plan_.chained.push_back(c.name);
    if (!after && (before || starting_.contains(c.name))) plan_.unchained.push_back(c.name);
  }

  /// Command interfaces that no controller offers belong to hardware.
  void add_hardware(const ControllerView& c, std::vector<std::string>& out) const {
    for (const std::string& name : c.commands)
      if (!offering_.contains(name)) out.push_back(name);
  }

  std::span<const ControllerView> all_;
  const SwitchRequest& request_;
  const Unavailable& unavailable_;
  using Places = std::unordered_map<std::string_view, std::vector<std::size_t>>;
  Places claiming_, offering_, exporting_;  ///< controllers by the interfaces that they use
  std::set<std::string> starting_, stopping_;
  SwitchPlan plan_;
};

}  // namespace

SwitchPlan plan_switch(std::span<const ControllerView> controllers, const SwitchRequest& request,
                       const Unavailable& unavailable) {
  return Planner(controllers, request, unavailable).plan();
}

std::vector<std::size_t> update_order(std::span<const ControllerView> controllers) {
  const std::size_t n = controllers.size();
  std::vector<std::vector<std::size_t>> later(n);
  std::vector<std::size_t> waits(n, 0);
  for (std::size_t a = 0; a < n; ++a) {
    if (controllers[a].references.empty() && controllers[a].exported.empty()) continue;
    for (std::size_t b = 0; b < n; ++b) {
      if (a == b) continue;
      if (comes_before(controllers[b], controllers[a])) later[b].push_back(a), ++waits[a];
      if (comes_before(controllers[a], controllers[b]) && controllers[b].references.empty() &&
          controllers[b].exported.empty())
        later[a].push_back(b), ++waits[b];
    }
  }
  // Next comes the first controller that waits for no other.
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> free;
  for (std::size_t i = 0; i < n; ++i)
    if (waits[i] == 0) free.push(i);
  std::vector<std::size_t> out;
  while (!free.empty()) {
    const std::size_t next = free.top();
    free.pop();
    out.push_back(next);
    for (const std::size_t b : later[next])
      if (--waits[b] == 0) free.push(b);
  }
  if (out.size() == n) return out;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < n; ++i)
    if (waits[i] > 0) names.push_back(controllers[i].name);
  throw Error("chain-circle", "these controllers wait for each other in a circle: " + join(names, ", "),
              "take one link of the chain out");
}

namespace {
/// Only controllers that offer interfaces can be links of a chain.
bool offers(const ControllerView& controller) {
  return !controller.references.empty() || !controller.exported.empty();
}
bool linked(const ControllerView& a, const ControllerView& b) {
  return (offers(a) || offers(b)) && (comes_before(a, b) || comes_before(b, a));
}
}  // namespace

std::vector<std::size_t> chain_of(std::span<const ControllerView> controllers, std::size_t first,
                                  const std::vector<bool>& active) {
  std::vector<bool> in(controllers.size(), false);
  in[first] = true;
  std::vector<std::size_t> found{first};
  for (std::size_t k = 0; k < found.size(); ++k)
    for (std::size_t j = 0; j < controllers.size(); ++j)
      if (active[j] && !in[j] && linked(controllers[found[k]], controllers[j])) {
        in[j] = true;
        found.push_back(j);
      }
  if (found.size() == 1) return found;
  std::vector<std::size_t> out;
  for (const std::size_t i : update_order(controllers))
    if (in[i]) out.push_back(i);
  return out;
}

}  // namespace polyarm::control
