#pragma once
/// Errors and signals of a controller of UFACTORY, over a connection to its command port. One thread at a
/// time; each call waits for answers.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/signals.hpp"
#include "drivers/xarm/ux_port.hpp"

namespace polyarm::xarm {

inline constexpr int kMostSignals = 16;  ///< digital inputs and outputs of the control box: CI0–7, DI0–7
inline constexpr int kMostToolSignals = 2;  ///< of the tool

/// What people see at the controller beside its motion.
struct Panel {
  int error = 0, warning = 0;
  std::uint32_t inputs = 0, outputs = 0, tool_inputs = 0, tool_outputs = 0;
};

/// NaN: stays as it is. The signals of the control box, then those of the tool.
struct Outputs {
  std::array<double, kMostSignals + kMostToolSignals> digital;
  Outputs() noexcept;
};

/// The signals that a driver reads and writes.
struct UsedSignals {
  wire::SignalRange inputs, outputs;
  bool tool = false;
};

class PanelPort {
 public:
  /// Keeps a reference to `port`.
  PanelPort(UxPort& port, UsedSignals used, Nanoseconds timeout)
      : port_(port), used_(used), timeout_(timeout) {}

  /// Nothing: see failure().
  std::optional<UxReply> ask(Register reg, const std::vector<std::uint8_t>& data = {});
  /// What was written before counts no more.
  void forget() { written_ = Outputs(); }
  /// Only what changed is written: somebody may have switched the others in UFACTORY Studio. False: see
  /// failure().
  bool write(const Outputs& wanted);
  bool read_signals(Panel& into);
  bool read_codes(Panel& into);

  // How every session begins. False: see failure().
  /// Clears error and warning; an error that is still there comes back, and is named.
  bool clear(bool may_clear_errors);
  bool enable_motors();
  bool set(Register reg, unsigned value);
  /// What kept the controller from becoming ready. Returns false.
  bool fail_with_error(Cause without_one);

  struct Why {
    Cause cause = Cause::none;
    int detail = 0;
    std::string text;
  };
  const Why& failure() const { return failure_; }
  /// Why the controller does not take commands: an error, somebody's stop, or motors that are off.
  Why explain_stop(Panel& into);

 private:
  bool fail(Cause cause, int detail = 0, std::string text = {});
  bool write_one(std::size_t at, bool on);
  bool read_tool(std::uint16_t address, std::uint32_t& into);

  UxPort& port_;
  UsedSignals used_;
  Nanoseconds timeout_;
  Outputs written_;
  Why failure_;
};

}  // namespace polyarm::xarm
