#include "polyarm/language/compliance.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "polyarm/language/operators.hpp"

namespace polyarm::program {

namespace {
[[noreturn]] void refuse(std::string what, std::string advice = {}) {
  throw OperationError{"bad-value", std::move(what), std::move(advice)};
}

double force_of(const Value& value, const char* name, double otherwise) {
  const data::Number n = *value.as_number();
  if (n.dimension == Dimension::none && n.value == 0) return otherwise;
  if (n.dimension != Dimension::force)
    refuse(std::string("'") + name + "' of comply() is a force, here is " + described(value),
           "write such as 20N");
  return n.value;
}

/// The axes in a text such as "x y rz"; `first` is the index of the first.
std::array<bool, 6> axes_of(const std::string& text, std::size_t& first) {
  constexpr std::array<std::string_view, 6> kAxes = {"x", "y", "z", "rx", "ry", "rz"};
  std::array<bool, 6> out{};
  first = kAxes.size();
  std::string word;
  const auto take = [&] {
    if (word.empty()) return;
    const auto at = static_cast<std::size_t>(std::find(kAxes.begin(), kAxes.end(), word) - kAxes.begin());
    if (at == kAxes.size())
      refuse("comply() yields along x y z and about rx ry rz, here is '" + word + "'",
             "write such as \"x y rz\"");
    if (first == kAxes.size()) first = at;
    out[at] = true;
    word.clear();
  };
  for (const char c : text)
    if (c == ' ' || c == ',')
      take();
    else
      word += c;
  take();
  if (first == kAxes.size()) refuse("comply() needs at least one axis", "write such as comply(\"z\")");
  return out;
}
}  // namespace

Compliance compliance_of(std::span<const Value> arguments) {
  constexpr double kMostForce = 100, kSoftest = 50, kHardest = 1e5, kMostReach = 0.2;
  Compliance out;
  std::size_t first = 0;
  out.axes = axes_of(*arguments[0].as_text(), first);
  const double force = force_of(arguments[1], "force", 0);
  if (force != 0 && first > 2)
    refuse("comply() presses along x, y or z, and the first of its axes is a rotation",
           "name the axis first");
  if (first < 3) out.push[first] = force;
  out.stiffness = arguments[2].as_number()->value;
  out.damping = arguments[3].as_number()->value;
  out.most = force_of(arguments[4], "most", kMostForce);
  out.reach = arguments[5].as_number()->value;
  if (!(out.stiffness >= 0 && out.stiffness <= kHardest))
    refuse("'stiffness' of comply() is from 0 to 100000 N/m, here is " + arguments[2].text());
  if (!(out.damping >= kSoftest && out.damping <= kHardest))
    refuse("'damping' of comply() is from 50 to 100000 N s/m, here is " + arguments[3].text());
  if (!(out.most > std::abs(force)))
    refuse("'most' of comply() is larger than the force with which the tool presses");
  if (!(out.reach > 0 && out.reach <= kMostReach))
    refuse("'reach' of comply() is above 0 and at most 200mm, here is " + arguments[5].text());
  return out;
}

}  // namespace polyarm::program
