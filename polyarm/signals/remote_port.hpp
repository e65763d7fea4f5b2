#pragma once
/// A port whose protocol runs in a separate process, `polyarm_link_KIND`, so that the library that parses
/// untrusted input shares no memory with robot control. If that process ends or does not answer, the link is
/// lost like a connection, and open() starts the process again.
#include <sys/types.h>

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/process/channel.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/pulse.hpp"
#include "polyarm/signals/link.hpp"
#include "polyarm/signals/link_exchange.hpp"

namespace polyarm::signals {

struct RemotePortOptions {
  /// Timeout of an answer, in addition to the far side's share (the link's timeout), ns. It covers name
  /// look-ups and a busy machine. After it the process is killed.
  Nanoseconds patience = 10'000'000'000;
  /// If the process sends no heartbeat for this long while an answer is due, it hangs and is killed.
  std::chrono::nanoseconds silence = process::kLongestSilence;
};

/// One thread calls open(), exchange() and close(). The process ends with that thread.
class RemotePort : public LinkPort {
 public:
  /// `program`: file of the program, which open() starts. Throws Error if the password cannot be read.
  RemotePort(LinkEntry entry, std::string program, RemotePortOptions options = {});
  ~RemotePort() override;

  void open() override;
  void close() noexcept override;
  void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                LinkReport& news) override;
  bool waits() const override { return waits_; }
  void give_up() noexcept override;

  /// Process id; 0 if there is no process. Any thread.
  pid_t process() const { return process_.load(std::memory_order_relaxed); }

 private:
  void start();
  template <class Fill>
  void order(LinkOrder what, Fill fill);
  /// Waits for the answer. Its content is in `message_` after the first byte. Throws Error("link-lost").
  process::Unpacker answer(LinkAnswer expected, Nanoseconds limit);
  bool receive(Nanoseconds until);
  [[noreturn]] void lose(const std::string& how);
  void remember(const std::vector<LinkValue>& values);

  LinkEntry entry_;
  const std::string program_;
  const RemotePortOptions options_;
  process::Child child_;
  std::unique_ptr<process::Channel> channel_;
  process::PulseWatch pulse_;
  std::vector<std::byte> message_;
  std::vector<std::optional<data::Value>> known_;  ///< by tag: last value exchanged in either direction
  bool waits_ = false;
  std::atomic<pid_t> process_{0};
  Descriptor give_up_;
};

}  // namespace polyarm::signals
