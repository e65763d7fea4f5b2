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

#include "polyarm/base/bounds.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/realtime/bell.hpp"

namespace polyarm::server {

using Text = std::shared_ptr<const std::string>;

/// Events of these kinds tell all there is (or all that has changed): where one waits to be sent, a newer one
/// takes its place.
enum class Kind : std::uint8_t { answer, status, tags, parts, program, plan, points, layout, log };

/// What all clients keep together.
struct Waiting {
  std::atomic<std::size_t> in{0}, out{0};  ///< bytes
};

class Client {
 public:
  /// What waits for the cell, and may wait to be sent.
  static constexpr std::size_t kMostIn = bounds::kClientInBytes, kMostUrgent = bounds::kUrgentLines,
                               kMostOut = bounds::kClientOutMessages, kMostOutBytes = bounds::kClientOutBytes;
  /// Lines a second, and in a burst; who sends more is sent away.
  static constexpr double kLinesASecond = bounds::kClientLinesASecond, kBurst = bounds::kClientBurst;

  struct Side {
    std::string address;                ///< of the other side
    bool local = true;                  ///< it is on this machine
    protocol::Role role = protocol::Role::administer;  ///< of the token that it has shown
  };
  /// `rope`: pulled when a line has come in; may be null, as may `all`.
  Client(std::uint64_t its_number, Side side, std::shared_ptr<realtime::BellRope> rope = nullptr,
         std::shared_ptr<Waiting> all = nullptr)
      : number(its_number),
        from(std::move(side.address)),
        local(side.local),
        role(side.role),
        rope_(std::move(rope)),
        all_(all ? std::move(all) : std::make_shared<Waiting>()) {}
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  const std::uint64_t number;  ///< counts up from 1
  const std::string from;      ///< address of the other side
  const bool local;            ///< it is on this machine
  const protocol::Role role;       ///< what its token allows

  // --- I/O thread
  /// Keeps the line, or refuses it where too much waits; false: it comes too fast. Everything is read at once,
  /// so that no stop waits behind what was sent before it. `now`: s, of any steady clock.
  bool take(std::string line, double now);
  struct Out {
    Text body;
    bool binary = false;
  };
  /// What to send next.
  std::optional<Out> next();

  // --- cell thread
  /// Stops, holds and heartbeats, which nothing else keeps waiting.
  std::vector<std::string> urgent();
  struct Line {
    std::string text;
    bool before_stop = false;  ///< a stop or hold came after it, and has overtaken it
    bool before_end = false;   ///< so has the end of all jogs
  };
  /// The next of all others.
  std::optional<Line> line();
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
  struct Urgent {
    bool stops = false, ends = false;  ///< a stop or hold; the end of all jogs
  };
  static std::optional<Urgent> urgent_of(const std::string& line);
  bool take_urgent(std::string line, Urgent urgent);
  void refuse(const std::string& line);
  void wake() { wake_.store(true, std::memory_order_release); }

  std::shared_ptr<realtime::BellRope> rope_;
  std::shared_ptr<Waiting> all_;
  mutable std::mutex mutex_;
  std::deque<std::string> urgent_, in_;
  std::size_t in_bytes_ = 0;
  std::size_t before_stop_ = 0, before_end_ = 0;  // of in_, from its front
  std::deque<std::pair<Kind, Text>> out_;
  std::size_t out_bytes_ = 0;
  Text frame_;
  double allowance_ = kBurst, bytes_allowed_ = bounds::kClientBurstBytes, refilled_ = 0;
  void add_out(std::size_t bytes) {
    out_bytes_ += bytes;
    all_->out += bytes;
  }
  void drop_out(std::size_t bytes) {
    out_bytes_ -= bytes;
    all_->out -= bytes;
  }
  /// Has it to go, or to miss events, since nobody reads what it is sent?
  bool too_much(std::size_t share) const;
  std::atomic<bool> gone_{false}, wake_{false};
  std::atomic<std::uint64_t> frames_left_out_{0}, events_left_out_{0};
};

}  // namespace polyarm::server
