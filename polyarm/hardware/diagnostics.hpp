#pragma once
/// State of the components of one loop, for lists and messages.
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/hardware/host_options.hpp"
#include "polyarm/realtime/overrun_watch.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::hardware {

struct Hosting;

/// Cell thread unless stated otherwise.
class Diagnostics {
 public:
  explicit Diagnostics(Hosting& hosting) : hosting_(hosting) {}

  HostedInfo info(std::size_t i) const;
  /// Why the component failed last: the loop's finding, otherwise the component's own reason; may be empty.
  std::string reason(std::size_t i) const;
  /// The component's own reason only; may be empty.
  std::string own_reason(std::size_t i) const;
  /// The interface whose value showed the last failure; empty if it was no single one.
  std::string blamed_interface(std::size_t i) const;
  /// The drivers' lines for the start of a run: "name: text".
  std::vector<std::string> summaries() const;
  /// Names for WorldState's contacts.
  const std::vector<std::string>& world_names() const;

  /// Health of the component's thread; null without a thread. Any thread.
  const realtime::ThreadHealth* thread_health(std::size_t i) const noexcept;
  const realtime::ThreadOptions& thread_options(std::size_t i) const;
  WhenLate when_late(std::size_t i) const;
  /// Cost of its read and write in the loop; empty for a component with a thread, and if not measured. Any
  /// thread.
  const realtime::PartHealth& part_health(std::size_t i) const noexcept;
  /// The component that the control thread is calling; -1: none. Any thread.
  int in_call() const noexcept;

  /// The next read or write that took longer than its budget; `who` is the component's index.
  bool take_overrun(realtime::Overrun& out);
  /// The next component whose thread became late (HostOptions::late_after); reported once until it is
  /// activated again.
  bool take_late(std::int32_t& who);

 private:
  Hosting& hosting_;
};

}  // namespace polyarm::hardware
