#include "polyarm/fleet/site_page.hpp"

#include "polyarm/access/token.hpp"
#include "polyarm/fleet/site_page_files.hpp"
#include "polyarm/server/port.hpp"

namespace polyarm::fleet {

namespace {

server::HttpReply reply_of(std::string text, const char* type) {
  server::HttpReply out;
  out.type = type;
  out.body = std::make_shared<const std::string>(std::move(text));
  out.headers.emplace_back("Cache-Control", "no-store");
  return out;
}

}  // namespace

class SitePage::Work : public server::Site {
 public:
  Work(const SiteWatch& watch, std::string site, std::uint16_t port) : watch_(watch), site_(std::move(site)) {
    server::PortOptions options;
    options.port = port;
    options.rules.token = server::make_token();  // nobody knows it: what is open is all there is
    port_ = std::make_unique<server::Port>(std::move(options), *this);
  }
  std::uint16_t port() const { return port_->number(); }

  bool is_open(const std::string& method, const std::string&) const override {
    return method == "GET" || method == "HEAD";
  }
  std::size_t most_body(const std::string&, const std::string&) const override { return 0; }
  std::shared_ptr<server::Client> welcome(server::Client::Side) override { return nullptr; }
  void handle(server::HttpRequest request, std::function<void(server::HttpReply)> reply) override {
    if (request.path == "/") return reply(reply_of(kPage, "text/html; charset=utf-8"));
    if (request.path == "/site.js") return reply(reply_of(kScript, "text/javascript; charset=utf-8"));
    if (request.path != "/api/site") return reply(server::plain(404, "there is no such file"));
    const nlohmann::json out{{"name", site_}, {"cells", json_of(watch_.reports())}};
    reply(reply_of(out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), "application/json"));
  }

 private:
  const SiteWatch& watch_;
  const std::string site_;
  std::unique_ptr<server::Port> port_;
};

SitePage::SitePage(const SiteWatch& watch, std::string site, std::uint16_t port)
    : work_(std::make_unique<Work>(watch, std::move(site), port)) {}
SitePage::~SitePage() = default;
std::uint16_t SitePage::port() const {
  return work_->port();
}

}  // namespace polyarm::fleet
