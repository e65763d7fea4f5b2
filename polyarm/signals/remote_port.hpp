#pragma once
/// A port whose protocol is spoken by a process of its own, `polyarm_link_KIND`: the library that parses what
/// strangers send shares no memory with what moves a robot. When that process ends, or gives no answer, the link
/// is lost like a connection, and open() starts the process anew.
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
  /// For an answer, beside what the far side may take by the link's timeout: names are looked up, the machine is
  /// busy. Longer, and the process is ended.
  Nanoseconds patience = 10'000'000'000;
  /// Without a sign of life while an answer is awaited: the process hangs, and is ended.
  std::chrono::nanoseconds silence = process::kLongestSilence;
};

/// open(), exchange() and close() belong to one thread, with which the process ends.
class RemotePort : public LinkPort {
 public:
  /// `program`: its file. The process is started by open(). Throws Error where the password cannot be read.
  RemotePort(LinkEntry entry, std::string program, RemotePortOptions options = {});
  ~RemotePort() override;

  void open() override;
  void close() noexcept override;
  void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                LinkNews& news) override;
  bool waits() const override { return waits_; }
  void give_up() noexcept override;

  /// Its process id; 0 where there is none. Any thread.
  pid_t process() const { return process_.load(std::memory_order_relaxed); }

 private:
  void start();
  template <class Fill>
  void order(LinkOrder what, Fill fill);
  /// Waits for the answer, which then is in `message_` behind its first byte. Throws Error("link-lost").
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
  std::vector<std::optional<data::Value>> known_;  ///< by tag: what the two sides told each other last
  bool waits_ = false;
  std::atomic<pid_t> process_{0};
  Descriptor give_up_;
};

}  // namespace polyarm::signals
