#pragma once
/// Fault injection on the wire of a simulated arm: which fault, and from which exchange on.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/servo_bus/fake_bus.hpp"
#include "drivers/servo_bus/setup.hpp"

namespace polyarm::servo_bus {

/// A list as users write it: `KIND@EXCHANGE[:JOINT][=VALUE]`, separated by spaces or semicolons.
///
///     silent:JOINT=EXCHANGES   the joint's servo answers no more, for so long; 0: for good
///     cut=EXCHANGES            the wires between adapter and servos are cut, the same
///     unplug                   the adapter is pulled, for good
///     lose, extra, wrong_sum, late =ANSWERS
///                              so many answers (1) lack a byte, have one too many, end with a wrong sum, or
///                              come after the next instruction only
///     garbage=ANSWERS          so many answers (1) begin with bytes that mean nothing
///     jump:JOINT=RAD           a hand turns the joint by so much (0.5)
///     block:JOINT              the joint is pressed against something, at full load
///
/// Without a joint, the first one is meant. Exchanges count from the component's activation.
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
