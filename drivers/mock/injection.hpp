#pragma once
/// Fault injection for mock components: which fault, and from which cycle on.
#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// A list in user syntax: `KIND@CYCLE[:JOINT][=VALUE]`, separated by spaces or semicolons.
///
///     read_error, write_error   the call fails once
///     deactivate                read requests deactivation, once
///     nan:JOINT                 the joint's position is NaN from then on
///     jump:JOINT=RAD            the joint's position is off by this much (default 0.5) from then on
///     freeze                    states are frozen from then on
///     slow=MS                   one read takes this long (default 50)
///
/// Without a joint, the first one is used. Cycles count from the component's activation, so a recovered
/// component gets its faults again. apply…(): control thread, no allocation.
class Injection {
 public:
  /// Throws Error("bad-value") with the valid forms. `joints`: names of the joints in the order of
  /// `positions`, which are their indices in the spans of read().
  void parse(const std::string& text, const std::vector<std::string>& joints, std::vector<int> positions,
             std::size_t states);
  bool empty() const noexcept { return entries_.empty(); }
  void begin() noexcept;  ///< cycles count from here
  /// Call it after the component has written its states.
  hardware::ReturnType after_read(std::span<double> states) noexcept;
  hardware::ReturnType after_write() const noexcept;
  /// The last injected fault as a sentence; empty if there is none.
  std::string reason() const;

 private:
  enum class Kind : std::uint8_t { read_error, write_error, deactivate, nan, jump, freeze, slow };
  struct Entry {
    Kind kind;
    std::uint64_t cycle;
    std::size_t state = 0;
    double value = 0;
    std::string joint;
  };
  std::vector<Entry> entries_;
  std::vector<double> frozen_;
  bool is_frozen_ = false;
  std::uint64_t cycle_ = 0;
  std::atomic<int> last_{-1};  ///< last injected entry
};

}  // namespace polyarm::drivers
