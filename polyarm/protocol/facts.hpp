#pragma once
/// What is known of a request before anybody asks it: its name, what it does, who may ask it.
#include <cstdint>
#include <optional>
#include <string_view>

#include "polyarm/protocol/members.hpp"

namespace polyarm::protocol {

/// Each may do what those before it may. All but `watch` also need control, which one screen has at a time.
enum class Role : std::uint8_t {
  watch,      ///< read, and bring to rest: hold and stop
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
  bool moves = false;                ///< it may make something move, or stop
  bool urgent = false;               ///< it begins though earlier requests of the same asker are not answered
  bool patient = false;              ///< it may wait for a person: later requests of the same asker begin meanwhile
  const char* watch_with = nullptr;  ///< with this flag (`dry`) it only reads: role `watch`
  const char* watch_without = nullptr;  ///< without this argument it only reads: role `watch`
  /// The pendant's port answers it, and not the cell. Such requests ignore arguments that they do not know.
  bool session = false;
};

}  // namespace polyarm::protocol
