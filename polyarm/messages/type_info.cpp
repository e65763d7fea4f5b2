#include "polyarm/messages/type_info.hpp"

#include <string>

namespace polyarm::messages {

namespace {
const TypeInfo* find_in(std::span<const TypeInfo* const> types, std::string_view name) {
  for (const TypeInfo* type : types) {
    const std::string_view full = type->name;
    if (full == name) return type;
    const std::size_t first = full.find('/'), last = full.rfind('/');
    const bool message = full.substr(first, last - first) == "/msg";
    if (message && name.size() + 4 == full.size() && name.substr(0, first) == full.substr(0, first) &&
        name.substr(first) == full.substr(last))
      return type;
  }
  return nullptr;
}
}  // namespace

const TypeInfo* find_type(std::string_view name, Distribution distribution) {
  std::span<const TypeInfo* const> own;
  if (distribution == Distribution::humble) own = humble_types();
  if (distribution == Distribution::kilted) own = kilted_types();
  const TypeInfo* found = find_in(own, name);
  return found ? found : find_in(types(), name);
}

}  // namespace polyarm::messages
