#pragma once
/// Checks whether requests about stopped motion are possible now, and says why not. Cell thread.
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::cell {

class Arming;
class ContactWatch;
class LifeCycle;
class Machine;
class Motions;
class Watches;

/// Each returns empty if the request is possible now; otherwise the reason, with the request to use instead.
std::optional<Problem> why_no_resume(const Machine& machine, const Motions& motions,
                                     const ContactWatch& contacts, const Watches& watches);
std::optional<Problem> why_no_discard(const Machine& machine);
std::optional<Problem> why_no_back(const Machine& machine, const Watches& watches);
std::optional<Problem> why_no_recover(const Machine& machine);
/// A program continues only while the cell runs.
std::optional<Problem> why_no_statement(const Machine& machine, const Arming& arming, const LifeCycle& life);

struct CellInside;
/// All of the above, and for each robot why it cannot be jogged.
protocol::PossibleNow possible_now(const CellInside& cell);

}  // namespace polyarm::cell
