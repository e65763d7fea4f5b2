#include "polyarm/fleet/site_page.hpp"

#include "polyarm/access/token.hpp"
#include "polyarm/server/port.hpp"

namespace polyarm::fleet {

namespace {

constexpr const char* kPage = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Polyarm site</title>
<style>
:root { color-scheme: light dark; --bad: #b3261e; --good: #1b7f3b; --wait: #9a6700; --line: #8884; }
body { font: 16px system-ui, sans-serif; margin: 1.5rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: .5rem .75rem; border-bottom: 1px solid var(--line); vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
.state { font-weight: 600; } .running { color: var(--good); } .held, .stopping, .backing { color: var(--wait); }
.fault, .silent { color: var(--bad); }
</style></head><body>
<h1 id="name">Site</h1><p id="sum" role="status"></p>
<table><thead><tr><th>Cell<th>State<th>Program<th class="number">Passes<th class="number">Availability<th class="number">Performance
<th class="number">Quality<th class="number">OEE<th>Version<th>What is wrong</tr></thead><tbody id="cells"></tbody></table>
<script src="/site.js"></script></body></html>
)";

constexpr const char* kScript = R"(
const percent = (share) => (share === null ? '–' : (100 * share).toFixed(1) + ' %');
function row(cell) {
  const summary = cell.summary ?? {}, state = cell.answers ? summary.state : 'silent';
  const tr = document.createElement('tr');
  const add = (text, kind = '') => { const td = tr.insertCell(); td.textContent = text ?? ''; td.className = kind; };
  add(cell.name);
  add(state, 'state ' + String(state).replace(/[^a-z]/g, ''));
  add(cell.answers && summary.program ? `${summary.program.name}: ${summary.program.state}` : '');
  add(summary.passes ?? '', 'number');
  for (const key of ['availability', 'performance', 'quality', 'oee']) add(percent(cell.oee[key]), 'number');
  add(summary.version);
  add(cell.words + (cell.answers || !cell.summary ? '' : ` (last values ${Math.round(cell.age_s)} s old)`));
  return tr;
}
async function look() {
  const sum = document.getElementById('sum');
  try {
    const site = await (await fetch('/api/site', { cache: 'no-store' })).json();
    document.getElementById('name').textContent = site.name;
    document.title = site.name;
    sum.textContent = `${site.cells.filter((each) => each.answers).length} of ${site.cells.length} cells answer`;
    document.getElementById('cells').replaceChildren(...site.cells.map(row));
  } catch {
    sum.textContent = 'polyarm fleet does not answer: the values are old';
  }
  setTimeout(look, 1000);
}
look();
)";

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
