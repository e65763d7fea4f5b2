#include "polyarm/signals/remote_port.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::signals {

namespace {
using process::Channel;
using process::Packer;
using process::Unpacker;

/// The far side may use the link's timeout for each request. A port makes at most one request per value that
/// it sends and per block that it reads.
constexpr std::size_t kMostBlocks = 32;
constexpr Nanoseconds kClosing = 1'000'000'000;

Nanoseconds clock_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

process::ChannelLimits limits() {
  process::ChannelLimits out;
  out.most_message = kMostLinkMessage;
  return out;
}
}  // namespace

RemotePort::RemotePort(LinkEntry entry, std::string program, RemotePortOptions options)
    : entry_(std::move(entry)),
      program_(std::move(program)),
      options_(options),
      known_(entry_.tags.size()),
      give_up_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  // The password is read here, where the cell's access rights apply; the process gets the password, not the
  // file.
  if (!entry_.password_file.empty()) entry_.password = trim(read_file(entry_.password_file));
  // A restarted process uses the same id, so that a broker ends the previous session.
  if (entry_.client_id.empty()) entry_.client_id = "polyarm-" + entry_.name + "-" + std::to_string(::getpid());
}

RemotePort::~RemotePort() {
  close();
}

void RemotePort::give_up() noexcept {
  const std::uint64_t once = 1;
  if (::write(give_up_.number(), &once, sizeof once) < 0) errno = 0;
}

void RemotePort::start() {
  try {
    channel_ = std::make_unique<Channel>(limits());
    const auto handed = channel_->of_child();
    child_.start(program_, {std::to_string(::getpid())}, handed);
  } catch (const Error& e) {
    throw Error("link-lost", e.problems().front().what);
  }
  process_.store(child_.process(), std::memory_order_relaxed);
  pulse_ = {};
  std::vector<LinkValue> known;
  for (std::size_t i = 0; i < known_.size(); ++i)
    if (known_[i]) known.push_back({i, *known_[i]});
  order(LinkOrder::begin, [&](Packer& out) {
    pack(out, entry_);
    pack(out, known);
  });
  waits_ = answer(LinkAnswer::done, options_.patience).truth();
}

template <class Fill>
void RemotePort::order(LinkOrder what, Fill fill) {
  Packer out(message_);
  out.number(static_cast<std::uint8_t>(what));
  fill(out);
  if (!channel_->send(message_, true)) lose("takes no more orders, and was ended");
}

void RemotePort::open() {
  if (!child_.running()) start();
  order(LinkOrder::open, [](Packer&) {});
  answer(LinkAnswer::done, options_.patience + 2 * entry_.timeout);
}

void RemotePort::exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                          LinkReport& news) {
  if (!child_.running()) lose("does not run");
  order(LinkOrder::exchange, [&](Packer& out) {
    out.number(now).number(patience);
    pack(out, writes);
  });
  const std::size_t requests = 2 + writes.size() + std::min(entry_.tags.size(), kMostBlocks);
  Unpacker in = answer(LinkAnswer::news,
                       options_.patience + patience + static_cast<Nanoseconds>(requests) * entry_.timeout);
  if (!unpack_reports(in, entry_, news)) {
    news = {};
    lose("broke the rules of the exchange, and was ended");
  }
  remember(writes);
  remember(news.values);
}

void RemotePort::remember(const std::vector<LinkValue>& values) {
  for (const LinkValue& each : values) known_[each.tag] = each.value;
}

/// The process stays alive for the next open(). It is killed if it does not close in time.
void RemotePort::close() noexcept {
  if (!child_.running()) return;
  try {
    order(LinkOrder::close, [](Packer&) {});
    answer(LinkAnswer::done, kClosing);
  } catch (const std::exception&) {  // the process has been killed
  }
}

Unpacker RemotePort::answer(LinkAnswer expected, Nanoseconds limit) {
  if (!receive(clock_now() + limit))
    lose("did not answer for " + format_number(seconds(limit / 100'000'000 * 100'000'000)) + " s, and was ended");
  Unpacker in(message_);
  const auto what = static_cast<LinkAnswer>(in.number<std::uint8_t>());
  if (what == LinkAnswer::failed) {
    const std::string why = printable_line(in.text(kMostLinkWords));
    if (in.good()) throw Error("link-lost", why);
  }
  if (!in.good() || what != expected) lose("broke the rules of the exchange, and was ended");
  return in;
}

/// Receives the next message. Returns false if none arrives until then.
bool RemotePort::receive(Nanoseconds until) {
  using Clock = process::PulseWatch::Clock;
  pulse_.restart(Clock::now());
  for (;;) {
    const auto received = channel_->receive(message_);
    if (received == Channel::Received::message) return true;
    if (received == Channel::Received::broken) lose("broke the rules of the exchange, and was ended");
    child_.listen();
    if (const auto ending = child_.ended()) lose(ending->text());
    const Nanoseconds left = until - clock_now();
    if (left <= 0) return false;
    if (pulse_.silent(*channel_, Clock::now(), options_.silence))
      lose("hangs: it sent nothing for " + format_number(seconds(options_.silence.count())) +
           " s, and was ended");
    if (channel_->may_sleep()) {
      std::array<pollfd, 4> fds{{{channel_->bell(), POLLIN, 0},
                                 {child_.end(), POLLIN, 0},
                                 {child_.errors(), POLLIN, 0},
                                 {give_up_.number(), POLLIN, 0}}};
      const Nanoseconds most = std::min<Nanoseconds>(left, std::chrono::nanoseconds(process::kPulse).count());
      if (::poll(fds.data(), fds.size(), static_cast<int>(most / 1'000'000) + 1) < 0) errno = 0;
      if (fds[3].revents != 0) lose("was ended, as the cell ends");
    }
    channel_->woken();
  }
}

void RemotePort::lose(const std::string& how) {
  child_.kill();
  channel_.reset();
  process_.store(0, std::memory_order_relaxed);
  throw Error("link-lost", entry_.address() + ": the process that speaks it (" + link_program(entry_.kind) + ") " + how);
}

}  // namespace polyarm::signals
