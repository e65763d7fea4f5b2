#pragma once
/// The fixed facts of a request: its name, what it does, and which role may send it.
#include <cstdint>
#include <optional>
#include <string_view>

#include "polyarm/protocol/members.hpp"

namespace polyarm::protocol {

/// Each role includes those before it. All but `watch` also need control, which one client has at a time.
enum class Role : std::uint8_t {
  watch,      ///< read, and stop motion: hold and stop
  operate,    ///< move, start and answer programs, set tags, record
  program,    ///< change programs, points and files
  administer  ///< controllers, hardware, parameters, other cells
};
template <>
struct Words<Role> {
  static constexpr const char* kNoun = "role";
  static constexpr const char* kWords[] = {"watch", "operate", "program", "administer"};
};
const char* name(Role role);
/// "watch" … "administer".
std::optional<Role> role_named(std::string_view text);

struct Facts {
  const char* name;  ///< "control.switch"
  Role role;
  const char* text;                  ///< one sentence for help and the reference
  bool moves = false;                ///< it may start or stop motion
  bool urgent = false;               ///< it starts even if earlier requests of the same client are not
                                     ///< answered yet
  bool patient = false;              ///< it may wait for a person; later requests of the same client can
                                     ///< start meanwhile
  const char* watch_with = nullptr;  ///< with this flag (`dry`) it only reads, and needs the role `watch`
  const char* watch_without = nullptr;  ///< without this argument it only reads, and needs the role `watch`
  /// True: the pendant's port answers it, not the cell. Such requests ignore unknown arguments.
  bool session = false;
};

}  // namespace polyarm::protocol
