#pragma once
/// Describes the thread options that the machine refused.
#include <string>
#include <vector>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {

/// Returns one sentence for each bit of `refused`. `asked` are the requested options; `who` names the thread
/// ("the control thread").
std::vector<std::string> refusals(unsigned refused, const ThreadOptions& asked, const std::string& who);

}  // namespace polyarm::realtime
