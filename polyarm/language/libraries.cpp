#include "polyarm/language/libraries.hpp"

#include <array>

namespace polyarm::program {

namespace {
struct Library {
  std::string_view name, text;
};

/// Searches with a force sensor (docs/searches.md). All moves are along and about the axes of the tool.
constexpr std::string_view kSearch = R"(# Ahead until something is touched; returns the pose of the contact.
func touch_ahead(reach = 50mm, stop_force = 10N, pace = 10mm/s)
  zero_force()
  movel tool_offset(here(), z = reach), speed pace, touch, until force() > stop_force else
    raise "nothing was touched within {reach:.1mm}"
  end
  return here()
end

# Further ahead until the force is reached; true if it was, false if the tool went the whole way.
func press_ahead(reach = 5mm, stop_force = 20N, pace = 5mm/s)
  movel tool_offset(here(), z = reach), speed pace, touch, until force() > stop_force
  return met()
end

# Points about the contact, from the middle outwards: at each one ahead, until the tool goes deeper than the
# surface by `deep`. True: it has found a hole and is in it.
func search_spiral(radius = 5mm, pitch = 1mm, deep = 2mm, stop_force = 10N, lift = 1mm, pace = 20mm/s)
  let surface = here()
  let most = floor((radius / pitch) ^ 2)
  for i in 0 .. most
    let out = pitch * sqrt(i)
    let above = tool_offset(surface, x = out * cos(i * 137.508deg), y = out * sin(i * 137.508deg), z = -lift)
    movel above, speed pace, touch
    movel tool_offset(above, z = lift + deep), speed pace, touch, until force() > stop_force
    if not met()
      return true
    end
  end
  movel tool_offset(surface, z = -lift), speed pace, touch
  return false
end

# The tool leans about its axes, more in each round, until it goes ahead by `deep`. True: it has.
func search_tilt(most = 6deg, step = 2deg, deep = 2mm, stop_force = 10N, pace = 10mm/s)
  let surface = here()
  let rounds = floor(most / step)
  for k in 1 .. rounds
    for side in 1 .. 4
      let lean = tool_offset(surface, rx = k * step * cos(side * 90deg), ry = k * step * sin(side * 90deg))
      movel lean, touch, speed pace
      movel tool_offset(lean, z = deep), speed pace, touch, until force() > stop_force
      if not met()
        return true
      end
    end
  end
  movel surface, touch, speed pace
  return false
end

# Ahead by `reach`; where it sticks, the tool goes back a little, turns to and fro, and tries again.
func push_with_wiggle(reach = 20mm, stop_force = 20N, turn_by = 3deg, tries = 10, pace = 10mm/s)
  let begin = here()
  let goal = tool_offset(begin, z = reach)
  for i in 1 .. tries
    movel goal, speed pace, touch, until force() > stop_force
    if not met()
      return true
    end
    let stuck = here()
    movel tool_offset(stuck, z = -1mm, rz = turn_by), speed pace, touch
    movel tool_offset(stuck, z = -1mm, rz = -turn_by), speed pace, touch
    movel tool_offset(stuck, z = -1mm), speed pace, touch
  end
  return false
end
)";

constexpr std::array kLibraries = {Library{"polyarm:search", kSearch}};
}  // namespace

std::optional<std::string_view> library_text(std::string_view name) {
  for (const Library& library : kLibraries)
    if (library.name == name) return library.text;
  return std::nullopt;
}

std::vector<std::string> library_names() {
  std::vector<std::string> out;
  for (const Library& library : kLibraries) out.emplace_back(library.name);
  return out;
}

}  // namespace polyarm::program
