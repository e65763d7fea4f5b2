#pragma once
/// Fault injection on the wire of a simulated arm: which fault, and from which exchange on.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/servo_bus/fake_bus.hpp"
#include "drivers/servo_bus/setup.hpp"

namespace polyarm::servo_bus {

/// A list in user syntax: `KIND@EXCHANGE[:JOINT][=VALUE]`, separated by spaces or semicolons.
///
///     silent:JOINT=EXCHANGES   the joint's servo is silent for this many exchanges; 0: permanently
///     cut=EXCHANGES            the line between adapter and servos is cut, likewise
///     unplug                   the adapter is unplugged permanently
///     lose, extra, wrong_sum, late =ANSWERS
///                              this many answers (1) lack a byte, have an extra one, end with a wrong sum,
///                              or come only after the next instruction
///     garbage=ANSWERS          this many answers (1) begin with garbage
///     jump:JOINT=RAD           the joint is turned by hand by this angle (0.5)
///     block:JOINT              the joint is blocked at full load
///
/// Without a joint, the first one is used. Exchanges count from the component's activation.
class FakeFaults {
 public:
  /// Throws Error("bad-value") with the valid forms.
  void parse(const std::string& text, const std::vector<JointSetup>& joints);
  void begin() { exchange_ = 0; }  ///< exchanges count from here
  /// Call it before each exchange; `position`: the register of a servo's position.
  void next(FakeBus& bus, const Register& position);

 private:
  enum class Kind : std::uint8_t { silent, cut, unplug, lose, extra, wrong_sum, late, garbage, jump, block };
  struct Entry {
    Kind kind;
    std::uint64_t at = 0;
    double value = 0;
    int id = 0;        ///< of the servo
    double steps = 0;  ///< of the servo, per rad of the joint
  };
  void begin(const Entry& entry, FakeBus& bus, const Register& position);
  static bool ends(const Entry& entry, std::uint64_t now);

  std::vector<Entry> entries_;
  Mischief mischief_;
  std::uint64_t exchange_ = 0;
};

}  // namespace polyarm::servo_bus
