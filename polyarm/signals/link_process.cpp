#include "polyarm/signals/link_process.hpp"

#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/process/channel.hpp"
#include "polyarm/process/child.hpp"
#include "polyarm/process/confinement.hpp"
#include "polyarm/process/pulse.hpp"
#include "polyarm/signals/link_exchange.hpp"

namespace polyarm::signals {

namespace {
using process::Channel;
using process::Packer;
using process::Unpacker;

/// Interval of checks for an order without a wake-up, ms.
constexpr int kCheck_ms = 1000;

class LinkProcess {
 public:
  LinkProcess(Channel& channel, MakeLinkPort make) : channel_(channel), make_(make) {}

  /// Returns the exit code.
  int run() {
    std::vector<std::byte> order;
    for (;;) {
      const auto received = channel_.receive(order);
      if (received == Channel::Received::broken || channel_.broken()) return 1;
      if (received == Channel::Received::nothing) {
        channel_.wait(kCheck_ms);
        continue;
      }
      Unpacker in(order);
      const auto what = static_cast<LinkOrder>(in.number<std::uint8_t>());
      try {
        obey(what, in);
      } catch (const Error& e) {
        fail(e.problems().front().what);
      } catch (const std::exception& e) {
        fail(e.what());
      }
    }
  }

 private:
  void obey(LinkOrder what, Unpacker& in) {
    if (what == LinkOrder::begin) return begin(in);
    if (!port_) throw Error("link-lost", "the link has not begun");
    if (what == LinkOrder::open) port_->open();
    if (what == LinkOrder::close) port_->close();
    if (what == LinkOrder::exchange) return exchange(in);
    tell(LinkAnswer::done, [](Packer&) {});
  }

  void begin(Unpacker& in) {
    const LinkEntry entry = unpack_entry(in);
    const std::vector<LinkValue> known = unpack_values(in);
    if (!in.good()) throw Error("link-lost", "the link is of another version of Polyarm");
    confine_to(entry);
    pulse_.emplace(channel_);
    port_.reset(make_(entry));
    port_->remember(known);
    tell(LinkAnswer::done, [&](Packer& out) { out.number(port_->waits()); });
  }

  /// Called before the library creates a thread. The code that parses untrusted input can then reach the far
  /// side and nothing else.
  static void confine_to(const LinkEntry& entry) {
    constexpr std::uint16_t kNames = 53;  // DNS over TCP, for long answers
    const auto port = static_cast<std::uint16_t>(entry.port);
    process::Confinement reach{{entry.ca_file, entry.certificate, entry.key}, {}, {}};
    reach.connects.emplace();
    reach.listens.emplace();
    if (entry.server)
      reach.listens->push_back(port);
    else
      *reach.connects = {port, kNames};
    process::confine(reach);
    process::filter_calls(lower(entry.host).ends_with(".local"));
  }

  void exchange(Unpacker& in) {
    const auto now = in.number<Nanoseconds>(), patience = in.number<Nanoseconds>();
    LinkReport news;
    port_->exchange(unpack_values(in), now, patience, news);
    tell(LinkAnswer::news, [&](Packer& out) { pack(out, news); });
  }

  void fail(const std::string& what) {
    tell(LinkAnswer::failed, [&](Packer& out) { out.text(what.substr(0, kMostLinkWords)); });
  }

  template <class Fill>
  void tell(LinkAnswer what, Fill fill) {
    Packer out(message_);
    out.number(static_cast<std::uint8_t>(what));
    fill(out);
    channel_.send(message_, true);
  }

  Channel& channel_;
  const MakeLinkPort make_;
  std::optional<process::Pulse> pulse_;
  std::unique_ptr<LinkPort> port_;
  std::vector<std::byte> message_;
};
}  // namespace

int serve_link(int argc, char** argv, MakeLinkPort make) {
  const int parent = argc == 2 ? std::atoi(argv[1]) : 0;
  if (parent <= 0) {
    std::fputs("this program is started by polyarm, which connects its links through it\n", stderr);
    return 2;
  }
  process::ChildRules rules;
  rules.handed = 3;
  rules.parent = parent;
  rules.most_memory = bounds::kLinkMemory;
  if (!process::become_child(rules)) return 1;
  ::signal(SIGPIPE, SIG_IGN);  // a lost connection is an error of the call
  try {
    process::ChannelLimits limits;
    limits.most_message = kMostLinkMessage;
    Channel channel(Channel::Inherited{}, limits);
    return LinkProcess(channel, make).run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}

}  // namespace polyarm::signals
