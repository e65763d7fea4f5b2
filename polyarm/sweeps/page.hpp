#pragma once
/// Draws the results of a sweep as one HTML page with pictures in SVG; it needs no network and no script.
#include <string>

#include "polyarm/sweeps/summary.hpp"

namespace polyarm::sweeps {

/// Maps of cycle time and clearance over base places, the robots by both, and what each value of an axis led
/// to. `measured`: clearances up to this were measured, m.
std::string page_of(const std::string& title, const Summary& summary, double measured);

}  // namespace polyarm::sweeps
