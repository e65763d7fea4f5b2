#pragma once
/// Why a request about stopped motion cannot be now, and what can. Cell thread.
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

/// Each: empty where it can be now; else why not, with the request that leads on.
std::optional<Problem> why_no_resume(const Machine& machine, const Motions& motions,
                                     const ContactWatch& contacts, const Watches& watches);
std::optional<Problem> why_no_discard(const Machine& machine);
std::optional<Problem> why_no_back(const Machine& machine, const Watches& watches);
std::optional<Problem> why_no_recover(const Machine& machine);
/// Statements of a program go on only while the cell runs.
std::optional<Problem> why_no_statement(const Machine& machine, const Arming& arming, const LifeCycle& life);

struct CellInside;
/// All of them, and for each robot why it cannot be jogged.
protocol::PossibleNow possible_now(const CellInside& cell);

}  // namespace polyarm::cell
