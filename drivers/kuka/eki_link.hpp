#pragma once
/// What every link to a KUKA controller does over EthernetKRL before its robot may move, and what the panel
/// says when it stops. One thread at a time; the calls may wait.
#include <string>

#include "drivers/kuka/eki.hpp"
#include "drivers/kuka/words.hpp"
#include "drivers/wire/link_base.hpp"

namespace polyarm::kuka {

class EkiLink : public wire::LinkBase<Cause> {
 protected:
  EkiLink(const std::string& host, int port, Nanoseconds timeout)
      : LinkBase("the controller at " + host), eki_(host, port, timeout) {}
  ~EkiLink() = default;

  /// Refuses with what made the connection fail. Returns false.
  bool refuse_eki();
  bool check_identity(const EkiIdentity& identity);
  /// Refuses with what a person has to change at the controller first. `drives_on`: the drives may be
  /// switched on.
  bool check_panel(const EkiState& state, bool drives_on, Nanoseconds timeout);
  /// Emergency stop, guard or mode; none if they allow motion.
  static Cause safety_cause(const EkiState& state, int& detail);
  /// A message, drives, or a program that does not run; none if it runs.
  static Cause program_cause(const EkiState& state);

  Eki eki_;

 private:
  bool switch_drives_on(Nanoseconds timeout);
};

}  // namespace polyarm::kuka
