#pragma once
/// Who may ask what: one list over the cell's requests and those of a session at the pendant's port. A pure
/// table; doors apply it.
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::cell {

/// Each may do what those before it may. All but `watch` also need control, which one screen has at a time.
enum class Role : std::uint8_t {
  watch,      ///< read, and bring to rest: hold and stop
  operate,    ///< move, start and answer programs, set tags, record
  program,    ///< change programs, points and files
  administer  ///< controllers, hardware, parameters, other cells
};
const char* name(Role role);
/// "watch" … "administer".
std::optional<Role> role_named(std::string_view text);

/// A request that only tells is `watch`, whatever it may change otherwise.
struct RequestRole {
  const char* request;
  Role role;
  const char* tells_with = nullptr;     ///< with this flag it only tells: `dry`
  const char* tells_without = nullptr;  ///< without this argument it only tells
};
/// One row for each request of the cell and of a session; a test compares the names.
const std::vector<RequestRole>& request_roles();

/// What `request` needs; administer where no row has its name, so that a forgotten one is safe.
Role role_needed(const std::string& request_name, const nlohmann::json& request);

/// The requests by role as Markdown: the table of docs/pendant.md.
std::string role_reference();

}  // namespace polyarm::cell
