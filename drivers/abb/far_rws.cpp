/// Robot Web Services of the simulated controller.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drivers/abb/far_services.hpp"
#include "drivers/wire/service.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

/// A client that does not read its answers is closed after this time. It is short because EGM shares the
/// thread.
constexpr Nanoseconds kWrite = 20'000'000;
constexpr const char* kCookie = "-http-session-=simulated::http.session::0; path=/; httponly";

std::string span(const std::string& name, const std::string& value) {
  std::string safe;
  for (const char c : value)
    safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return "<span class=\"" + name + "\">" + safe + "</span>";
}

/// A path without its prefix; nothing if it has another one.
std::optional<std::string> behind(const std::string& path, const std::string& prefix) {
  if (!path.starts_with(prefix)) return std::nullopt;
  return path.substr(prefix.size());
}

/// The signal of ".../signals/network/device/name", with percent signs decoded.
std::string signal_of(const std::string& path) {
  const std::string name = wire::form_value("name=" + path, "name");
  return name.substr(name.rfind('/') + 1);
}

}  // namespace

FarRws::FarRws(Machine& machine, FarFaults& faults, int version)
    : machine_(machine), faults_(faults), version_(version), nonce_("6f3a1c" + std::to_string(version)) {
  if (second()) context_.emplace(wire::TlsContext::End::server);
}

void FarRws::set_user(const std::string& user, const std::string& password) {
  user_ = user;
  password_ = password;
}

void FarRws::listen(const std::string& address, int port) {
  std::string why;
  listener_ = wire::listen_tcp(address, port, why);
  if (!listener_) throw Error("no-port", why, "choose another port, or end the program that uses it");
  port_ = wire::local_port(listener_.number());
}

void FarRws::descriptors(std::vector<int>& out) const {
  out.push_back(listener_.number());
  for (const auto& client : clients_) out.push_back(client->channel.descriptor());
}

void FarRws::drop() {
  clients_.clear();
}

void FarRws::serve() {
  close_unfinished();
  while (Descriptor socket = wire::accept_tcp(listener_.number()))
    if (!faults_.power_off && clients_.size() < bounds::kFarSideClients) {
      clients_.push_back(std::make_unique<Client>());
      clients_.back()->channel = wire::Channel(std::move(socket), context_ ? &*context_ : nullptr);
      clients_.back()->begun = realtime::monotonic_now();
    }
  if (faults_.power_off) return drop();
  for (auto& client : clients_) read(*client);
  std::erase_if(clients_, [](const auto& client) { return client->gone; });
}

/// Connections that never finish a handshake or a request must not take the places of others.
void FarRws::close_unfinished() {
  const Nanoseconds before = realtime::monotonic_now() - request_time_;
  std::erase_if(clients_, [&](const auto& client) { return client->begun > 0 && client->begun < before; });
}

void FarRws::read(Client& client) {
  std::array<std::uint8_t, 8192> bytes;
  for (int turn = 0; turn < wire::kReadsInTurn; ++turn) {
    const wire::Received got = client.channel.read(bytes);
    if (got.got == wire::Got::nothing) return;
    if (got.got != wire::Got::bytes) return void(client.gone = true);
    client.reader.take({reinterpret_cast<const char*>(bytes.data()), got.count});
    while (const auto request = client.reader.next()) {
      client.begun = 0;
      take(client, *request);
    }
    if (client.begun == 0 && client.reader.unfinished()) client.begun = realtime::monotonic_now();
    if (client.reader.failed()) client.gone = true;
    if (client.gone) return;
  }
}

bool FarRws::allowed(const wire::HttpMessage& request) const {
  const auto login = request.header("Authorization");
  if (!login || faults_.login) return false;
  return second() ? wire::http_basic_matches(*login, user_, password_)
                  : wire::http_digest_matches(*login, nonce_, user_, password_, request.method);
}

std::string FarRws::challenge() const {
  return second() ? "Basic realm=\"validusers@robapi.abb\""
                  : "Digest realm=\"validusers@robapi.abb\", domain=\"/\", qop=\"auth\", nonce=\"" + nonce_ +
                        "\", opaque=\"0\", algorithm=\"MD5\", stale=\"false\"";
}

void FarRws::take(Client& client, const wire::HttpMessage& request) {
  ++requests_;
  if (faults_.mute) return;
  if (faults_.nonsense) {
    client.channel.write("220 this is no HTTP\r\n\r\n", kWrite);
    return void(client.gone = true);
  }
  wire::HttpMessage out;
  Answer made{503, ""};
  if (!faults_.busy) {
    client.known = !faults_.login && (client.known || allowed(request));
    made = client.known ? answer(request) : Answer{401, ""};
  }
  out.status = made.status;
  out.body = std::move(made.body);
  if (out.status == 401) out.headers.emplace_back("WWW-Authenticate", challenge());
  out.headers.emplace_back("Content-Type",
                           second() ? "application/xhtml+xml;v=2.0" : "application/xhtml+xml");
  if (client.known) out.headers.emplace_back("Set-Cookie", kCookie);
  if (!client.channel.write(wire::http_text(out), kWrite)) client.gone = true;
}

FarRws::Answer FarRws::page(const std::string& kind, const std::string& title, const std::string& spans) {
  return {200,
          "<?xml version=\"1.0\" encoding=\"utf-8\"?><html xmlns=\"http://www.w3.org/1999/xhtml\"><head>"
          "<title>" +
              title + "</title></head><body><div class=\"state\"><ul><li class=\"" + kind + "\" title=\"" +
              title + "\">" + spans + "</li></ul></div></body></html>"};
}

FarRws::Answer FarRws::refusal(int status, const std::string& text) {
  return {status,
          "<?xml version=\"1.0\" encoding=\"utf-8\"?><html xmlns=\"http://www.w3.org/1999/xhtml\"><body>"
          "<div class=\"status\">" +
              span("code", "-1073442809") + span("msg", text) + "</div></body></html>"};
}

FarRws::Answer FarRws::done(const std::string& wrong) const {
  return wrong.empty() ? Answer{204, ""} : refusal(400, wrong);
}

FarRws::Answer FarRws::answer(const wire::HttpMessage& request) {
  const std::size_t mark = request.target.find('?');
  const std::string path = request.target.substr(0, mark);
  const std::string query = mark == std::string::npos ? "" : request.target.substr(mark + 1);
  if (second() && request.header("Accept").value_or("").find("v=2.0") == std::string::npos)
    return refusal(406, "Accept must name version 2.0");
  if (request.method == "GET") return get(path);
  if (second() && request.header("Content-Type").value_or("").find("v=2.0") == std::string::npos)
    return refusal(415, "Content-Type must name version 2.0");
  if (faults_.forbidden) return refusal(403, "Operation rejected: the user has no grant for it");
  if (request.method == "PUT") return put(path, request.body);
  return request.method == "POST" ? post(path, query, request.body) : refusal(405, "Method not allowed");
}

FarRws::Answer FarRws::event_log() const {
  std::string out =
      "<?xml version=\"1.0\" encoding=\"utf-8\"?><html xmlns=\"http://www.w3.org/1999/xhtml\"><body>"
      "<div class=\"state\"><ul>";
  for (const RwsEvent& event : machine_.events())
    out += fmt::format("<li class=\"elog-message-li\" title=\"/rw/elog/0/{}\">", event.sequence) +
           span("msgtype", std::to_string(event.kind)) + span("code", std::to_string(event.code)) +
           span("src-name", "MC0") + span("title", event.title) + "</li>";
  return {200, out + "</ul></div></body></html>"};
}

FarRws::Answer FarRws::get(const std::string& path) {
  const std::string panel = second() ? "/rw/panel/ctrl-state" : "/rw/panel/ctrlstate";
  if (path == panel) return page("pnl-ctrlstate", "ctrlstate", span("ctrlstate", machine_.control()));
  if (path == "/rw/panel/opmode") return page("pnl-opmode", "opmode", span("opmode", machine_.mode_text()));
  if (path == "/rw/panel/speedratio")
    return page("pnl-speedratio", "speedratio",
                span("speedratio", std::to_string(std::lround(100 * machine_.speed_ratio))));
  if (path == "/rw/rapid/execution")
    return page("rap-execution", "execution",
                span("ctrlexecstate", machine_.program_runs() ? "running" : "stopped") +
                    span("cycle", machine_.runs_once() ? "once" : "forever"));
  const std::string options =
      "<ul><li class=\"sys-option-li\" title=\"0\">" + span("option", "RobotWare Base") + "</li>" +
      (faults_.no_option ? ""
       : second()        ? "<li class=\"sys-option-li\" title=\"1\">" +
                        span("option", "3124-1 Externally Guided Motion") + "</li>"
                  : "<li class=\"sys-option-li\" title=\"1\">" +
                        span("option", "689-1 Externally Guided Motion (EGM)") + "</li>") +
      "</ul>";
  if (path == "/rw/system")
    return page("sys-system-li", "system",
                span("name", "simulated") + span("rwversion", machine_.options().software) +
                    span("rwversionname", machine_.options().software) + (second() ? "" : options));
  if (path == "/rw/system/options") return page("sys-options-li", "options", options);
  if (path == "/rw/elog/0") return event_log();
  if (path == "/rw/rapid/tasks")
    return page("rap-task-li", "T_ROB1",
                span("name", "T_ROB1") + span("active", "On") + span("motiontask", "TRUE"));
  if (path == "/rw/rapid/modules" || path == "/rw/rapid/tasks/T_ROB1/modules") {
    std::string names;
    for (const std::string& name : machine_.options().modules) names += span("name", name);
    return page("rap-module-info-li", "modules", names);
  }
  if (path == "/rw/motionsystem/mechunits/ROB_1/jointtarget") {
    std::string values;
    for (std::size_t i = 0; i < 6; ++i)
      values += span(fmt::format("rax_{}", i + 1), fmt::format("{:.10g}", machine_.q()[i]));
    return page("ms-jointtarget", "jointtarget", values);
  }
  if (const auto name = behind(path, "/rw/iosystem/signals/")) {
    const auto found = machine_.signals().find(signal_of(*name));
    if (found == machine_.signals().end()) return refusal(404, "Unknown signal");
    return page("ios-signal", found->first,
                span("name", found->first) + span("lvalue", found->second ? "1" : "0"));
  }
  if (path == "/logout") return {200, ""};
  return refusal(404, "Unknown resource");
}

FarRws::Answer FarRws::change_panel(const std::string& path, const std::string& form) {
  if (path.starts_with("/rw/panel/ctrl")) {
    const bool on = wire::form_value(form, "ctrl-state") == "motoron";
    return done(on && faults_.refuse_motors ? "Operation not allowed: motors" : machine_.switch_motors(on));
  }
  const auto ratio = parse_number(wire::form_value(form, "speed-ratio"));
  if (!ratio || *ratio < 0 || *ratio > 100) return refusal(400, "Invalid speed ratio");
  if (!master_) return refusal(403, "Mastership is needed");
  machine_.speed_ratio = *ratio / 100;
  return {204, ""};
}

FarRws::Answer FarRws::change_program(const std::string& action, const std::string& form) {
  if (action == "start")
    return done(faults_.refuse_start ? "Operation not allowed: start"
                                     : machine_.start_program(wire::form_value(form, "cycle") == "once"));
  if (action == "stop") {
    machine_.stop_program("stop of Robot Web Services");
    return {204, ""};
  }
  if (!master_) return refusal(403, "Mastership is needed");
  return action == "resetpp" ? done(machine_.reset_pointer()) : refusal(404, "Unknown action");
}

FarRws::Answer FarRws::post(const std::string& path, const std::string& query, const std::string& form) {
  const std::string action = wire::form_value(query, "action");
  if (path.starts_with("/rw/panel/")) return change_panel(path, form);
  if (path == "/rw/rapid/execution") return change_program(action, form);
  if (const auto verb = behind(path, "/rw/rapid/execution/")) return change_program(*verb, form);
  if (path.starts_with("/rw/mastership")) {
    const bool request = action == "request" || path.ends_with("/request");
    if (request && faults_.mastership) return refusal(403, "Mastership is held by another client");
    master_ = request;
    return {204, ""};
  }
  if (auto name = behind(path, "/rw/iosystem/signals/")) {
    if (name->ends_with("/set-value")) name->resize(name->size() - 10);
    const std::string value = wire::form_value(form, "lvalue");
    if (value != "0" && value != "1") return refusal(400, "Invalid value");
    const std::string wrong = machine_.set_signal(signal_of(*name), value == "1");
    return wrong.empty() ? Answer{204, ""} : refusal(wrong.starts_with("Unknown") ? 404 : 403, wrong);
  }
  if (path.starts_with("/rw/rapid/tasks/T_ROB1") && (action == "loadmod" || path.ends_with("/loadmod"))) {
    const std::string file = wire::form_value(form, "modulepath");
    const std::string name = file.substr(file.rfind('/') + 1);
    if (!name.ends_with(".mod")) return refusal(400, "Not a module");
    machine_.options().modules.insert(name.substr(0, name.size() - 4));
    return {204, ""};
  }
  return refusal(404, "Unknown resource");
}

FarRws::Answer FarRws::put(const std::string& path, const std::string& text) {
  const bool fits = path.starts_with("/fileservice/") && text.starts_with("MODULE ");
  return fits ? Answer{200, ""} : refusal(400, "Not a file that this controller takes");
}

}  // namespace polyarm::abb
