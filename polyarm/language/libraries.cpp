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

# Presses ahead with a constant force until the tool is deeper by `deep`, or the time is over. True: it is deeper.
func push_ahead(push_force = 20N, deep = 2mm, longest = 3s)
  let begin = here()
  let over = clock() + longest
  let deeper = false
  comply("z", force = push_force, reach = deep + 2mm, most = 5 * push_force)
  while clock() < over and not deeper
    wait 10ms
    set deeper = distance(here(), begin) >= deep
  end
  stiff()
  return deeper
end

# Towards `goal` until the force is reached, and again whenever what it presses on gives way, until the tool is `deep` farther or
# the time is over. True: it is farther.
func push_towards(goal, push_force = 20N, deep = 2mm, longest = 5s, pace = 5mm/s)
  let begin = here()
  let target = interpolate(begin, goal, min(1, deep / max(distance(begin, goal), 0.001mm)))
  let over = clock() + longest
  while clock() < over
    movel target, speed pace, touch, until force() > push_force
    if not met()
      return true
    end
    wait 20ms
  end
  return false
end

# A line to `goal` that swings by `wide` to both sides, once on each `pitch`: along the y axis of the tool, turned about its
# z axis by `plane`.
func weave_to(goal, wide = 3mm, pitch = 6mm, plane = 0deg, pace = 20mm/s)
  let begin = here()
  let points = 4 * max(1, round(distance(begin, goal) / pitch))
  let swing = [wide * sin(i * 90deg) for i in 1 .. points]
  movel [tool_offset(interpolate(begin, goal, i / points), x = -swing[i] * sin(plane), y = swing[i] * cos(plane)) for i in 1 .. points], smooth, speed pace, touch
end
)";

/// Docking of bases with wheels (docs/moves.md).
constexpr std::string_view kBase =
    R"(# The pose in front of a dock, from two places on its face: its left and its right end, as the base sees them. It is
# `away` from the middle of the line between them, and the front of the base points to the dock.
func dock_pose(left, right, away = 500mm)
  let facing = atan2(right.x - left.x, left.y - right.y)
  let middle = interpolate(left, right, 50%)
  return middle with x = middle.x - away * cos(facing) with y = middle.y - away * sin(facing) with rx = 0deg with ry = 0deg with rz = facing
end

# To that pose around obstacles, and then straight ahead until `gap` is left.
func dock_at(left, right, away = 500mm, gap = 100mm, pace = 50mm/s)
  drive dock_pose(left, right, away)
  drive away - gap, speed pace
end

# Backwards from `gap` until `away` is left, and then to a pose around obstacles.
func undock_to(goal, away = 500mm, gap = 100mm, pace = 100mm/s)
  if away > gap
    drive gap - away, speed pace
  end
  drive goal
end
)";

constexpr std::array kLibraries = {Library{"polyarm:base", kBase}, Library{"polyarm:search", kSearch}};
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
