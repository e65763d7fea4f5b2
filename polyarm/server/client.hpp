#pragma once
/// Both queues of one WebSocket: requests that came in, answers and events that go out. Both are bounded; a
/// newer state frame replaces one that was not sent yet.
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/access/logins.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/request.hpp"
#include "polyarm/realtime/bell.hpp"
#include "polyarm/users/audit_log.hpp"

namespace polyarm::server {

using Text = std::shared_ptr<const std::string>;

/// An event of any kind but `answer` and `log` replaces an unsent event of the same kind.
enum class Kind : std::uint8_t { answer, status, tags, parts, program, plan, near, points, layout, log };

/// Totals over all clients.
struct Waiting {
  std::atomic<std::size_t> in{0}, out{0};  ///< bytes
};

class Client {
 public:
  /// Limits of the queues: incoming requests, and outgoing messages.
  static constexpr std::size_t kMostIn = bounds::kClientInBytes, kMostUrgent = bounds::kUrgentLines,
                               kMostOut = bounds::kClientOutMessages, kMostOutBytes = bounds::kClientOutBytes;
  /// Rate limit for incoming lines: per second, and in a burst. A client that exceeds it is disconnected.
  static constexpr double kLinesASecond = bounds::kClientLinesASecond, kBurst = bounds::kClientBurst;

  struct Side {
    std::string address;                ///< of the client
    bool local = true;                  ///< true if the client is on this machine
    protocol::Role role = protocol::Role::administer;  ///< of the token that the client sent
    std::shared_ptr<Login> login = nullptr;            ///< of a user; null: the client came by a link
  };
  /// `rope` is pulled when a line comes in. `rope` and `all` may be null.
  Client(std::uint64_t its_number, Side side, std::shared_ptr<realtime::WakeupHandle> rope = nullptr,
         std::shared_ptr<Waiting> all = nullptr)
      : number(its_number),
        from(std::move(side.address)),
        local(side.local),
        role(side.role),
        login(std::move(side.login)),
        rope_(std::move(rope)),
        all_(all ? std::move(all) : std::make_shared<Waiting>()) {}
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  const std::uint64_t number;  ///< counts up from 1
  const std::string from;      ///< address of the client
  const bool local;            ///< true if the client is on this machine
  const protocol::Role role;       ///< what its token allows
  const std::shared_ptr<Login> login;  ///< of a user; may be null

  // --- who it is; any thread
  /// What others see if the client calls itself `given`: the name of a user comes first.
  std::string shown_name(const std::string& given) const;
  /// For the audit log; `shown`: the name that others see.
  users::Actor actor(const std::string& shown) const;
  /// Throws Error("no-role") if its role is less than `needed` for the request.
  void require_role(protocol::Role needed, const std::string& request) const;

  // --- I/O thread
  /// Queues the line; answers `busy` if the queue is full. Returns false if lines come too fast. All input is
  /// read at once, so a stop never waits behind earlier messages. `now`: s, of any steady clock.
  bool take(std::string line, double now);
  struct Out {
    Text body;
    bool binary = false;
  };
  /// The next message to send; nothing if there is none.
  std::optional<Out> next();

  // --- cell thread
  /// Stops, holds and heartbeats; no other request delays them.
  std::vector<std::string> urgent();
  struct Line {
    std::string text;
    bool before_stop = false;  ///< a stop or hold came after this line and was taken first
    bool before_end = false;   ///< the same for the end of all jogs
    /// Throws Error("overtaken") if the request was sent before a stop but is read after it, so that it
    /// cannot move what was stopped.
    void require_not_overtaken(const protocol::RequestType& type, const protocol::Any& arguments) const;
  };
  /// The next line that is not urgent.
  std::optional<Line> line();
  /// Queues the answer. Returns false if the client has left, or is disconnected because it reads too little.
  bool answer(std::string line);
  /// True if an event of this kind is still unsent; it would be replaced, so send the full state, not the
  /// changes.
  bool waits(Kind kind) const;
  void put(Kind kind, Text text);
  void put_state(Text frame);

  // --- any thread
  bool gone() const { return gone_.load(std::memory_order_acquire); }
  void leave() { gone_.store(true, std::memory_order_release); }
  /// Set by the thread that queues a message, cleared by the thread that sends.
  bool take_wake() { return wake_.exchange(false, std::memory_order_acq_rel); }
  std::uint64_t omitted_frames() const { return omitted_frames_.load(std::memory_order_relaxed); }
  std::uint64_t omitted_events() const { return omitted_events_.load(std::memory_order_relaxed); }

 private:
  struct Urgent {
    bool stops = false, ends = false;  ///< a stop or hold; the end of all jogs
  };
  static std::optional<Urgent> urgent_of(const std::string& line);
  bool take_urgent(std::string line, Urgent urgent);
  void refuse(const std::string& line);
  void wake() { wake_.store(true, std::memory_order_release); }

  std::shared_ptr<realtime::WakeupHandle> rope_;
  std::shared_ptr<Waiting> all_;
  mutable std::mutex mutex_;
  std::deque<std::string> urgent_, in_;
  std::size_t in_bytes_ = 0;
  std::size_t before_stop_ = 0, before_end_ = 0;  // counts of lines at the front of in_
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
  /// True if too much is unsent: with `share` 1 the client is disconnected, with 2 it misses events.
  bool too_much(std::size_t share) const;
  std::atomic<bool> gone_{false}, wake_{false};
  std::atomic<std::uint64_t> omitted_frames_{0}, omitted_events_{0};
};

}  // namespace polyarm::server
