#pragma once
/// Chooses robots of the catalogue by name, pattern or condition.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::sweeps {

/// The robots that a text means, in the order of the catalogue. A text is one of:
///   a name            "universal_robots/ur5e", or "ur5e"
///   a pattern         "ur*", "abb/*": of the whole name, or of the model alone
///   a condition       "payload >= 5kg and reach < 900mm and axes == 6"
///   a file            "my_robot.urdf", beside `folder`
/// Throws Error("unknown-robot" | "bad-condition") with `where`.
std::vector<std::string> choose_robots(const std::string& text,
                                       const std::vector<description::CatalogueEntry>& catalogue,
                                       const std::string& folder, const Location& where);

}  // namespace polyarm::sweeps
