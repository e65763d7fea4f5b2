#pragma once
/// Contacts of a simulated world, as a cell tells of them. Cell thread.
#include <deque>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::cell {

/// Whose motion a contact came of.
enum class ContactDuring { program, jog, move, start, other };
const char* name(ContactDuring during);

/// "2.10 mm"; below 0.1 mm with two significant digits.
std::string depth_text(double depth_m);

struct ContactReport {
  std::string a, b;    ///< "arm/forearm", "arm/tool", "fixture table", "part cube", "floor"
  std::string robot;   ///< whose motion it was; empty: nobody knows
  int number = 0;      ///< of the findings
  Nanoseconds time = 0;
  double depth = 0;    ///< m, the deepest so far
  Vec3 position;       ///< m, in the world
  bool now = false;    ///< it touches now
  ContactDuring during = ContactDuring::other;
  Location where;      ///< the move of the program, where that was under way
  /// "arm/forearm touched fixture table at 1.234 s, 2.10 mm deep".
  std::string sentence() const;
  /// {a, b, depth_m, at_s, doing}
  Facts facts() const;
};

/// Keeps the newest contacts, and those that still touch.
class ContactWatch {
 public:
  static constexpr std::size_t kKept = 16;
  /// Looks at a cycle; the contacts that are new in it, oldest first, without whose motion they are. Theirs
  /// until the next call.
  std::vector<ContactReport*> tick(const control::Snapshot& snapshot, const std::vector<std::string>& names);
  const std::deque<ContactReport>& list() const { return list_; }
  /// Something touches now.
  bool touching() const { return touching_ != nullptr; }
  /// One of those that touch now; null: nothing does.
  const ContactReport* touching_now() const { return touching_; }

 private:
  void follow(const hardware::WorldState& world);
  void make_room();

  std::deque<ContactReport> list_;
  const ContactReport* touching_ = nullptr;
  int seen_ = 0;
};

struct CellSetup;
class Machine;
/// The answer of `contacts`, and what the pendant's status has of it.
protocol::ContactState contact_state(const CellSetup& setup, const Machine& machine,
                                     const ContactWatch& contacts);

}  // namespace polyarm::cell
