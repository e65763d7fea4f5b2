#include "polyarm/base/bounds.hpp"

#include <fmt/format.h>

namespace polyarm::bounds {

const std::vector<Room>& all() {
#define POLYARM_BOUND(name, value, unit, what, beyond) {#name, value, unit, what, beyond},
#define POLYARM_BOUND_LIST(title, list) {title, {list(POLYARM_BOUND)}},
  static const std::vector<Room> rooms = {POLYARM_BOUNDS(POLYARM_BOUND_LIST)};
#undef POLYARM_BOUND_LIST
#undef POLYARM_BOUND
  return rooms;
}

namespace {

/// 65536 bytes are 64 KiB.
std::string amount(const Bound& bound) {
  constexpr std::uint64_t kKi = 1024, kMi = kKi * kKi;
  const bool bytes = std::string(bound.unit) == "bytes";
  if (bytes && bound.value % kMi == 0) return fmt::format("{} MiB", bound.value / kMi);
  if (bytes && bound.value % kKi == 0) return fmt::format("{} KiB", bound.value / kKi);
  return fmt::format("{} {}", bound.value, bound.unit);
}

}  // namespace

std::string reference() {
  std::string out;
  for (const Room& room : all()) {
    out += fmt::format("## {}\n\n| what | at most | beyond |\n|---|---|---|\n", room.title);
    for (const Bound& bound : room.bounds)
      out += fmt::format("| {} | {} | {} |\n", bound.what, amount(bound), bound.beyond);
    out += "\n";
  }
  return out;
}

}  // namespace polyarm::bounds
