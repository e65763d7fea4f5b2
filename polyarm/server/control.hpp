#pragma once
/// Decides which client may move the cell. One client has control; another asks it before it takes over.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace polyarm::server {

/// An event for one client, or for all.
struct ControlReport {
  enum class What { asked, given, refused, taken, lost, free };
  std::uint64_t to = 0;  ///< client; 0: all clients
  What what = What::asked;
  std::uint64_t other = 0;  ///< the client that asks, or that has control now
};

/// Does no I/O: the caller passes the time (s). Client numbers begin at 1.
class Control {
 public:
  /// If the holder does not answer a request for control within this time (s), it loses control.
  static constexpr double kTimeout = 10;

  std::uint64_t holder() const { return holder_; }
  /// The client that waits for the holder's answer; 0: none.
  std::uint64_t asker() const { return asker_; }
  bool holds(std::uint64_t client) const { return client != 0 && client == holder_; }
  /// Time until the holder loses control, s; 0 if no client asks.
  double left(double now) const;

  enum class Taken { yes, asked, others };  ///< others: another client is already asking
  /// `at_once`: takes control without asking; the holder is only informed.
  Taken take(std::uint64_t client, bool at_once, double now);
  bool release(std::uint64_t client);
  /// The holder's answer to the client that asks. Returns false if this client is not the holder, or no
  /// client asks.
  bool answer(std::uint64_t client, bool give);
  /// The client has disconnected.
  void gone(std::uint64_t client);
  void tick(double now);
  std::vector<ControlReport> take_reports() { return std::exchange(news_, {}); }

 private:
  void hand_to_asker(ControlReport::What to_old);

  std::uint64_t holder_ = 0, asker_ = 0;
  double until_ = 0;
  std::vector<ControlReport> news_;
};

}  // namespace polyarm::server
