#pragma once
/// What a machine did not permit a thread, in words.
#include <string>
#include <vector>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {

/// One sentence for each bit of `refused`, of what was asked for `who` ("the control thread").
std::vector<std::string> refusals(unsigned refused, const ThreadOptions& asked, const std::string& who);

}  // namespace polyarm::realtime
