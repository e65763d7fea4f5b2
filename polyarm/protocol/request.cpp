#include "polyarm/protocol/request.hpp"

#include <algorithm>
#include <map>

#include "polyarm/protocol/describe.hpp"
#include "polyarm/protocol/families.hpp"

namespace polyarm::protocol {

const char* name(Role role) {
  return Words<Role>::kWords[static_cast<std::size_t>(role)];
}

std::optional<Role> role_named(std::string_view text) {
  const auto& words = Words<Role>::kWords;
  const auto at = std::find(std::begin(words), std::end(words), text);
  if (at == std::end(words)) return std::nullopt;
  return static_cast<Role>(at - std::begin(words));
}

const std::vector<const RequestType*>& request_types() {
  static const std::vector<const RequestType*> all = [] {
    std::vector<const RequestType*> out;
    for (const FamilyOfRequests& family : kFamilies)
      out.insert(out.end(), family.requests().begin(), family.requests().end());
    return out;
  }();
  return all;
}

const RequestType* find_request(const std::string& name) {
  static const std::map<std::string, const RequestType*> by_name = [] {
    std::map<std::string, const RequestType*> out;
    for (const RequestType* type : request_types()) out[type->facts->name] = type;
    return out;
  }();
  const auto found = by_name.find(name);
  return found == by_name.end() ? nullptr : found->second;
}

Role role_needed(const RequestType& type, const Any& arguments) {
  const Facts& facts = *type.facts;
  const auto given = [&](const char* key) -> const Json* {
    const auto found = arguments.json().find(key);
    return found != arguments.json().end() && !found->is_null() ? &*found : nullptr;
  };
  if (facts.watch_with) {
    const Json* const flag = given(facts.watch_with);
    if (flag && flag->is_boolean() && flag->get<bool>()) return Role::watch;
  }
  if (facts.watch_without && !given(facts.watch_without)) return Role::watch;
  return facts.role;
}

Role role_needed(const Request& request) {
  const Facts& facts = request.facts();
  if (!facts.watch_with && !facts.watch_without) return facts.role;
  return role_needed(request.type(), request.arguments());
}

Any Request::arguments() const {
  return written(*type_->arguments, value_.get());
}

}  // namespace polyarm::protocol
