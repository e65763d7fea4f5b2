#pragma once
/// All components of one control loop: their life cycle, and the narrow views for other parts.
///
/// | user | view |
/// |---|---|
/// | the cell thread | Hardware: builds components and runs their life cycle |
/// | the controller manager | Components: names, groups, offered interfaces |
/// | the control thread | Exchange: read and write |
/// | lists and messages | Diagnostics |
#include <memory>
#include <string>

#include "polyarm/hardware/components.hpp"
#include "polyarm/hardware/diagnostics.hpp"
#include "polyarm/hardware/exchange.hpp"
#include "polyarm/hardware/host_options.hpp"
#include "polyarm/hardware/transition.hpp"

namespace polyarm::hardware {

/// Cell thread.
class Hardware : public Components {
 public:
  Hardware(InterfaceTable& table, realtime::Jobs& jobs);
  ~Hardware();

  Exchange& exchange() noexcept { return exchange_; }
  Diagnostics& diagnostics() noexcept { return diagnostics_; }
  const Diagnostics& diagnostics() const noexcept { return diagnostics_; }

  /// Initialises the component and adds its interfaces to the table. Throws Error if it refuses.
  void add(std::unique_ptr<Component> component, const ComponentContext& context, HostOptions options = {});
  /// Brings every component to its initial state, in order of addition. Throws Error that names component and
  /// step.
  void configure_and_activate();
  void configure_and_activate(Caller& caller);
  /// active → inactive → finalized, in reverse order; call after the control thread has ended. Never throws.
  /// If the caller stops waiting for a component's callback, or for its thread's read or write, the component
  /// is removed from the list and never freed; returns false then.
  bool shut_down() noexcept;
  bool shut_down(Caller& caller) noexcept;

  /// Begins one life-cycle transition. Run the result on any thread; when it is done, finish() on this thread
  /// changes the state and returns the transition to run next (on_error after an error), or null. Meanwhile
  /// only the loop calls the component, and other transitions of it throw Error("busy"). Throws
  /// Error("wrong-state") if the component is not in the transition's start state. finish() throws
  /// Error("component-failed") if the callback returned failure or error; after an error on_error decides
  /// between unconfigured and finalized. The loop reads a component from the cycle after `configure` and
  /// writes it from the cycle after `activate`. Before deactivate, cleanup and shutdown the loop must release
  /// it: begin_deactivate() and begin_cleanup().
  std::shared_ptr<Transition> begin(std::size_t i, Step step);
  /// Begins to replace an unconfigured or finalized component. The new one must offer the same interfaces;
  /// otherwise finish() throws Error("other-interfaces") with the first difference.
  std::shared_ptr<Transition> begin_replace(std::size_t i, std::unique_ptr<Component> component,
                                            const ComponentContext& context);
  std::shared_ptr<Transition> finish(Transition& done);
  /// Calls begin, run and finish on the calling thread.
  void run(std::size_t i, Step step);
  /// Throws Error("busy") while the component is in a callback.
  void require_idle(std::size_t i) const;
  /// The callback that is running; null if none is.
  const Transition* pending(std::size_t i) const noexcept;
  /// Makes the loop release the commands, or the component; begin the transition when the job is done.
  std::shared_ptr<realtime::Job> begin_deactivate(std::size_t i);
  std::shared_ptr<realtime::Job> begin_cleanup(std::size_t i);

  /// Forces all state and command interfaces of this name to `value`; NaN ends it. Do not call while another
  /// thread steps the loop. Throws Error("unknown-interface") if there is none.
  void force(const std::string& interface_name, double value);

 private:
  class Letting;
  static void leave_behind(std::unique_ptr<HostedComponent> hosted);
  void make_runner(HostedComponent& hosted, Nanoseconds loop_period);
  std::shared_ptr<realtime::Job> let(std::size_t i, bool reading, bool writing);
  std::shared_ptr<Transition> pend(std::size_t i, Step step);
  void succeed(std::size_t i, Step step);
  void settle_error(HostedComponent& hosted, const Transition& done);
  void take_new(HostedComponent& hosted, Transition& done);
  void go(std::shared_ptr<Transition> next, Caller& caller);
  void note_world();

  Exchange exchange_{*hosting_};
  Diagnostics diagnostics_{*hosting_};
  std::vector<std::unique_ptr<Component>> retired_;  // replaced; the control thread may read one's world
};

}  // namespace polyarm::hardware
