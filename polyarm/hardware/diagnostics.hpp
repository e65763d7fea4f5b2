#pragma once
/// How the components of one loop are doing, for lists and messages.
#include <cstdint>
#include <string>
#include <vector>

#include "polyarm/hardware/host_options.hpp"
#include "polyarm/realtime/overrun_watch.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::hardware {

struct Hosting;

/// Cell thread, unless a function says otherwise.
class Diagnostics {
 public:
  explicit Diagnostics(Hosting& hosting) : hosting_(hosting) {}

  HostedInfo info(std::size_t i) const;
  /// Why the component failed last: what the loop found, else the component's own words; may be empty.
  std::string reason(std::size_t i) const;
  /// The component's own words alone; may be empty.
  std::string own_reason(std::size_t i) const;
  /// The interface whose value showed the last failure; empty where no single one did.
  std::string blamed_interface(std::size_t i) const;
  /// What drivers say about themselves at the start of a run: "name: text".
  std::vector<std::string> summaries() const;
  /// Names for WorldState's contacts.
  const std::vector<std::string>& world_names() const;

  /// How the component's thread is doing; null where it has none. Any thread.
  const realtime::ThreadHealth* thread_health(std::size_t i) const noexcept;
  const realtime::ThreadOptions& thread_options(std::size_t i) const;
  WhenLate when_late(std::size_t i) const;
  /// What its read and write in the loop cost together; empty for one with a thread, and unless measured. Any
  /// thread.
  const realtime::PartHealth& part_health(std::size_t i) const noexcept;
  /// The component whose read or write the control thread is in; -1: none. Any thread.
  int in_call() const noexcept;

  /// The next read or write that took longer than its budget; `who` is the component's index.
  bool take_overrun(realtime::Overrun& out);
  /// The next component whose thread became late (HostOptions::late_after), once until it is let in again.
  bool take_late(std::int32_t& who);

 private:
  Hosting& hosting_;
};

}  // namespace polyarm::hardware
