#pragma once
/// Tracks the contacts of a simulated world for reports. Cell thread.
#include <deque>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/protocol/motion.hpp"

namespace polyarm::cell {

/// The kind of motion that caused a contact. `rest`: no robot moved.
enum class ContactDuring { program, jog, move, start, rest, other };
const char* name(ContactDuring during);

/// "2.10 mm"; below 0.1 mm with two significant digits.
std::string depth_text(double depth_m);

struct ContactReport {
  std::string a, b;    ///< "arm/forearm", "arm/tool", "fixture table", "part cube", "floor"
  std::string robot;   ///< the robot whose motion caused it; empty if none did, or if that is unknown
  int number = 0;      ///< number of the finding
  Nanoseconds time = 0;
  double depth = 0;    ///< largest depth so far, m
  Vec3 position;       ///< in the world, m
  bool now = false;    ///< true while it touches
  ContactDuring during = ContactDuring::other;
  Location where;      ///< the program's move at that time; empty without one
  /// "arm/forearm touched fixture table at 1.234 s, 2.10 mm deep".
  std::string sentence() const;
  /// {a, b, depth_m, at_s, doing}
  Facts facts() const;
};

/// Keeps the newest contacts, preferring those that still touch.
class ContactWatch {
 public:
  static constexpr std::size_t kKept = 16;
  /// Processes one cycle. Returns its new contacts, oldest first, whose cause is not filled in yet. The
  /// pointers are valid until the next call.
  std::vector<ContactReport*> tick(const control::Snapshot& snapshot, const std::vector<std::string>& names);
  const std::deque<ContactReport>& list() const { return list_; }
  /// True if any contact touches now.
  bool touching() const { return touching_ != nullptr; }
  /// One of the contacts that touch now; null if there is none.
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
/// The answer of the `contacts` request; part of it is in the pendant's status.
protocol::ContactState contact_state(const CellSetup& setup, const Machine& machine,
                                     const ContactWatch& contacts);

}  // namespace polyarm::cell
