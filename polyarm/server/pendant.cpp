#include "polyarm/server/pendant.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <unistd.h>

#include <array>

#include "polyarm/base/text.hpp"
#include "polyarm/server/port.hpp"
#include "polyarm/server/sessions.hpp"
#include "polyarm/server/site.hpp"
#include "polyarm/server/token.hpp"
#include "polyarm/server/viewers.hpp"

namespace polyarm::server {

namespace {

/// Host names of this machine, lower case.
std::vector<std::string> own_names() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return {};
  const std::string own = lower(name.data());
  return {own, own + ".local"};
}

/// An address of this machine that other machines can reach; empty if there is none.
std::string outside_address() {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return {};
  std::string out;
  for (const ifaddrs* each = all; each && out.empty(); each = each->ifa_next) {
    if (!each->ifa_addr || each->ifa_addr->sa_family != AF_INET) continue;
    if ((each->ifa_flags & IFF_LOOPBACK) != 0 || (each->ifa_flags & IFF_UP) == 0) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(each->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size())) out = text.data();
  }
  ::freeifaddrs(all);
  return out;
}

PortOptions port_options(const PendantOptions& options) {
  PortOptions out;
  out.address = !options.listen ? "127.0.0.1" : options.listen->empty() ? "0.0.0.0" : *options.listen;
  out.port = options.port;
  out.certificate = options.certificate;
  out.key = options.key;
  out.rules.token = options.token;
  for (const protocol::Role role : {protocol::Role::watch, protocol::Role::operate, protocol::Role::program})
    out.rules.lesser.emplace_back(token_for(options.token, role), role);
  out.rules.loopback = !options.listen;
  if (options.listen) out.rules.names = own_names();
  return out;
}

}  // namespace

class Pendant::Work {
 public:
  Work(PendantOptions options, cell::Observer& next)
      : options_(std::move(options)),
        sessions(next, options_.version),
        viewers_(options_.version),
        site_(options_, sessions, viewers_),
        port_(std::make_unique<Port>(port_options(options_), site_)) {
    site_.set_port(port_->number());
    viewers_.set_wake([this] { port_->wake(); });
  }
  ~Work() {
    viewers_.set_wake({});
    viewers_.detach();
    sessions.detach();
    site_.stop();
    port_.reset();
  }

  void serve() {
    for (const Problem& problem : site_.take_problems()) sessions.journal().on_problem(0, problem);
    const bool told = sessions.serve(), shown = viewers_.serve();
    if (told || shown) port_->wake();
  }
  void take() {
    if (sessions.take()) port_->wake();
  }
  void attach(cell::CellView& cell) {
    site_.show(cell);
    sessions.attach(cell);
    viewers_.attach(cell);
  }
  void detach() {
    viewers_.detach();
    sessions.detach();
    site_.show_nothing();
    port_->wake();
  }
  /// Other machines get https if there is a certificate; this machine gets http.
  std::string link(const std::string& host, bool outside, protocol::Role role) const {
    return (outside && !options_.certificate.empty() ? "https://" : "http://") + host + ":" +
           std::to_string(port_->number()) + "/?token=" + token_for(options_.token, role);
  }
  std::string outside_link(protocol::Role role) const {
    if (!options_.listen) return {};
    const bool any = options_.listen->empty() || *options_.listen == "0.0.0.0";
    const std::string address = any ? outside_address() : *options_.listen;
    if (address.empty()) return {};
    return link(address.find(':') == std::string::npos ? address : "[" + address + "]", true, role);
  }
  std::string link_for(protocol::Role role) const {
    const std::string outside = outside_link(role);
    return outside.empty() ? link("localhost", false, role) : outside;
  }
  const std::string& fingerprint() const { return options_.fingerprint; }
  std::uint16_t port() const { return port_->number(); }
  Counts counts() const {
    Counts out = sessions.counts();
    const Port::Counts port = port_->counts();
    out.connections = port.connections;
    out.refused = port.refused;
    out.timed_out = port.timed_out;
    return out;
  }

 private:
  PendantOptions options_;

 public:
  Sessions sessions;

 private:
  Viewers viewers_;
  PageSite site_;
  std::unique_ptr<Port> port_;
};

Pendant::Pendant(PendantOptions options, cell::Observer& next)
    : work_(std::make_unique<Work>(std::move(options), next)) {}
Pendant::~Pendant() = default;
cell::Observer& Pendant::observer() {
  return work_->sessions.journal();
}
void Pendant::attach(cell::CellView& cell) {
  work_->attach(cell);
}
void Pendant::detach() {
  work_->detach();
}
void Pendant::serve() {
  work_->serve();
}
void Pendant::set_wakeup(const std::shared_ptr<realtime::Bell>& bell) {
  work_->sessions.set_wakeup(bell);
}
void Pendant::take() {
  work_->take();
}
std::optional<cell::RestartRequest> Pendant::take_restart_request() {
  return work_->sessions.take_restart_request();
}
std::string Pendant::link() const {
  return work_->link("localhost", false, protocol::Role::administer);
}
std::string Pendant::outside_link() const {
  return work_->outside_link(protocol::Role::administer);
}
std::string Pendant::link_for(protocol::Role role) const {
  return work_->link_for(role);
}
std::string Pendant::fingerprint() const {
  return work_->fingerprint();
}
std::uint16_t Pendant::port() const {
  return work_->port();
}
Pendant::Counts Pendant::counts() const {
  return work_->counts();
}

}  // namespace polyarm::server
