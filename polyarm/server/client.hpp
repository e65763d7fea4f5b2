#pragma once
/// One WebSocket as both sides see it: what came in, what is to go out. Bounded both ways; the latest state
/// takes the place of one that was not sent yet.
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::server {

using Text = std::shared_ptr<const std::string>;

/// Events of these kinds tell all there is (or all that has changed): where one waits to be sent, a newer one
/// takes its place.
enum class Kind : std::uint8_t { answer, status, tags, parts, program, plan, points, layout, log };

class Client {
 public:
  /// Lines that wait for the cell before nothing more is read; what may wait to be sent.
  static constexpr std::size_t kMostLines = 64, kMostOut = 4096, kMostOutBytes = 16 << 20;
  /// Lines a second, and in a burst; who sends more is sent away.
  static constexpr double kLinesASecond = 500, kBurst = 2000;

  /// `rope`: pulled when a line has come in; may be null.
  Client(std::uint64_t its_number, std::string address, bool on_this_machine,
         std::shared_ptr<realtime::BellRope> rope = nullptr)
      : number(its_number), from(std::move(address)), local(on_this_machine), rope_(std::move(rope)) {}

  const std::uint64_t number;  ///< counts up from 1
  const std::string from;      ///< address of the other side
  const bool local;            ///< it is on this machine

  // --- I/O thread
  /// Keeps the line; false: it comes too fast. `now`: s, of any steady clock.
  bool take(std::string line, double now);
  /// May more be read from it?
  bool has_room() const;
  struct Out {
    Text body;
    bool binary = false;
  };
  /// What to send next.
  std::optional<Out> next();

  // --- cell thread
  std::vector<std::string> lines(std::size_t most);
  /// False when it is gone, or reads so little that it has to go.
  bool answer(std::string line);
  /// True where one of this kind waits to be sent: then what has changed since then is not enough.
  bool waits(Kind kind) const;
  void put(Kind kind, Text text);
  void put_state(Text frame);

  // --- any thread
  bool gone() const { return gone_.load(std::memory_order_acquire); }
  void leave() { gone_.store(true, std::memory_order_release); }
  /// Set by whoever gave it something, taken by the thread that sends.
  bool take_wake() { return wake_.exchange(false, std::memory_order_acq_rel); }
  std::uint64_t frames_left_out() const { return frames_left_out_.load(std::memory_order_relaxed); }
  std::uint64_t events_left_out() const { return events_left_out_.load(std::memory_order_relaxed); }

 private:
  void wake() { wake_.store(true, std::memory_order_release); }

  std::shared_ptr<realtime::BellRope> rope_;
  mutable std::mutex mutex_;
  std::deque<std::string> in_;
  std::deque<std::pair<Kind, Text>> out_;
  std::size_t out_bytes_ = 0;
  Text frame_;
  double allowance_ = kBurst, refilled_ = 0;
  std::atomic<bool> gone_{false}, wake_{false};
  std::atomic<std::uint64_t> frames_left_out_{0}, events_left_out_{0};
};

}  // namespace polyarm::server
