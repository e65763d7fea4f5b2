#pragma once
/// What both modes of the driver do over the Remote Motion Interface while nothing moves: connect, clear
/// alarms, begin remote motion. One thread at a time; each call may wait.
#include <optional>
#include <string>

#include "drivers/fanuc/rmi.hpp"
#include "drivers/fanuc/words.hpp"
#include "drivers/wire/link_base.hpp"

namespace polyarm::fanuc {

/// The functions that return bool set refused() when they return false.
class RmiLink : public wire::LinkBase<Cause> {
 public:
  const std::string& rmi_version() const { return rmi_.version(); }

 protected:
  RmiLink(std::string where, Nanoseconds connect_timeout)
      : LinkBase(std::move(where)), answer_timeout_(connect_timeout) {}

  /// `streams`: asks for a session that may start Stream Motion, as far as the controller knows that.
  bool connect_rmi(const std::string& host, int port, bool streams);
  std::optional<RmiMessage> command_of(const char* name, const RmiLine& line);
  std::optional<RmiMessage> command_of(const char* name) { return command_of(name, {"Command", name}); }
  /// Refuses with the cause of the controller's alarm, or with `otherwise`.
  bool refuse_alarm(Cause otherwise);
  /// A person activated the component: alarms whose cause is gone are cleared. Nothing moves.
  bool clear_alarms(Nanoseconds timeout);
  bool initialize();

  RmiSession rmi_;

 private:
  Nanoseconds answer_timeout_;
};

}  // namespace polyarm::fanuc
