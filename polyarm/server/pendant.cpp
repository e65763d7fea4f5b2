#include "polyarm/server/pendant.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>

#include "polyarm/access/token.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/server/cell_metrics.hpp"
#include "polyarm/server/documents.hpp"
#include "polyarm/server/metrics_text.hpp"
#include "polyarm/server/port.hpp"
#include "polyarm/server/scrapes.hpp"
#include "polyarm/server/sessions.hpp"
#include "polyarm/server/site.hpp"
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

PortOptions port_options(const PendantOptions& options, Logins& logins) {
  PortOptions out;
  out.address = !options.listen ? "127.0.0.1" : options.listen->empty() ? "0.0.0.0" : *options.listen;
  out.port = options.port;
  out.certificate = options.certificate;
  out.key = options.key;
  out.rules.token = options.token;
  for (const protocol::Role role : {protocol::Role::watch, protocol::Role::operate, protocol::Role::program})
    out.rules.lesser.emplace_back(token_for(options.token, role), role);
  out.rules.login = [&logins](std::string_view token) { return logins.find(token, steady_seconds()); };
  out.rules.loopback = !options.listen;
  if (options.listen) out.rules.names = own_names();
  return out;
}

bool is_loopback(const std::string& address) {
  return address.starts_with("127.") || address == "::1";
}

PortOptions metrics_options(const PendantOptions::Metrics& metrics) {
  PortOptions out;
  out.address = metrics.address;
  out.port = metrics.port;
  out.rules.token = make_token();  // nobody knows it: nothing but /metrics is open
  out.rules.loopback = is_loopback(metrics.address);
  if (!out.rules.loopback) out.rules.names = own_names();
  return out;
}

}  // namespace

class Pendant::Work {
 public:
  Work(PendantOptions options, cell::Observer& next)
      : options_(std::move(options)),
        logins_(options_.users, 3600 * options_.log_in_hours),
        sessions(next, options_.version, options_.audit),
        viewers_(options_.version),
        metrics_(options_.version),
        metrics_site_(scrapes_),
        site_(options_, sessions, viewers_, logins_, scrapes_),
        port_(std::make_unique<Port>(port_options(options_, logins_), site_)) {
    site_.set_port(port_->number());
    viewers_.set_wake([this] { port_->wake(); });
    if (options_.metrics)
      metrics_port_ = std::make_unique<Port>(metrics_options(*options_.metrics), metrics_site_);
  }
  ~Work() {
    viewers_.set_wake({});
    viewers_.detach();
    sessions.detach();
    metrics_.detach(steady_seconds());
    site_.stop();
    scrapes_.close();
    metrics_port_.reset();
    port_.reset();
  }

  void serve() {
    for (const Problem& problem : site_.take_problems()) sessions.journal().on_problem(0, problem);
    const double now = steady_seconds();
    metrics_.tick(now);
    if (now - scrapes_answered_ >= kScrapesEvery_s) answer_scrapes(now);
    if (now - logins_checked_ >= Logins::kRereadEvery_s) {
      logins_checked_ = now;
      logins_.tick(now);
      port_->wake();  // closes the connections whose log-in has ended, also if nothing is sent to them
    }
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
    metrics_.attach(cell, steady_seconds());
  }
  void detach() {
    metrics_.detach(steady_seconds());
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
  std::uint16_t metrics_port() const { return metrics_port_ ? metrics_port_->number() : std::uint16_t{0}; }
  Counts counts() const {
    Counts out = sessions.counts();
    const Port::Counts port = port_->counts();
    out.connections = port.connections;
    out.refused = port.refused;
    out.timed_out = port.timed_out;
    return out;
  }

 private:
  /// Each text is made once for all who wait: anybody may ask for the metrics, and this thread has a cell to
  /// serve.
  void answer_scrapes(double now) {
    if (!scrapes_.any()) return;
    scrapes_answered_ = now;
    Text text, json;
    for (auto& [kind, reply] : scrapes_.take()) {
      HttpReply out;
      const bool prometheus = kind == Scrapes::Kind::prometheus;
      Text& made = prometheus ? text : json;
      if (!made)
        made = std::make_shared<const std::string>(prometheus ? metrics_.prometheus(counts())
                                                              : dump(metrics_.summary(counts())));
      out.type = prometheus ? MetricsText::kMediaType : "application/json";
      out.body = made;
      out.headers.emplace_back("Cache-Control", "no-store");
      reply(std::move(out));
    }
  }

  PendantOptions options_;
  Logins logins_;
  double logins_checked_ = 0, scrapes_answered_ = 0;
  static constexpr double kScrapesEvery_s = 0.05;

 public:
  Sessions sessions;

 private:
  Viewers viewers_;
  CellMetrics metrics_;
  Scrapes scrapes_;
  MetricsSite metrics_site_;
  PageSite site_;
  std::unique_ptr<Port> port_, metrics_port_;
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
std::uint16_t Pendant::metrics_port() const {
  return work_->metrics_port();
}
std::uint16_t Pendant::port() const {
  return work_->port();
}
std::optional<users::Actor> Pendant::actor(const void* client) const {
  return work_->sessions.actor(client);
}
Pendant::Counts Pendant::counts() const {
  return work_->counts();
}

}  // namespace polyarm::server
