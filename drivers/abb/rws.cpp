#include "drivers/abb/rws.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::abb {

namespace {

constexpr std::size_t kMostValue = 4096;

/// The five entities of XML.
std::string plain_text(std::string_view text) {
  constexpr std::pair<std::string_view, char> kEntities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    bool found = false;
    for (const auto& [name, character] : kEntities)
      if (!found && text.substr(i).starts_with(name)) {
        out += character;
        i += name.size();
        found = true;
      }
    if (!found) out += text[i++];
  }
  return out;
}

/// The path of a signal: "name" or "network/device/name".
std::string signal_path(const std::string& name) {
  return "/rw/iosystem/signals/" + wire::form_text(name);
}

Cause cause_of(wire::HttpClient::Failure failure) {
  using enum wire::HttpClient::Failure;
  switch (failure) {
    case unreachable:
      return Cause::unreachable;
    case tls:
      return Cause::tls;
    case certificate:
      return Cause::certificate;
    case bad_answer:
      return Cause::rws_bad_data;
    default:
      return Cause::rws_silent;
  }
}

}  // namespace

bool RwsIdentity::guided() const {
  return std::any_of(options.begin(), options.end(), [](const std::string& one) {
    return one.find("Externally Guided Motion") != std::string::npos ||
           one.find("689-1") != std::string::npos || one.find("3124-1") != std::string::npos;
  });
}

bool RwsIdentity::recent() const {
  const auto parts = split_words(software, ".");
  const auto number = [&](std::size_t i) {
    return i < parts.size() ? parse_number(parts[i]).value_or(0) : 0.0;
  };
  return number(0) > 6 || (number(0) == 6 && number(1) * 100 + number(2) >= 701);
}

std::vector<std::string> rws_values(std::string_view body, std::string_view name) {
  std::vector<std::string> out;
  const std::string opening = "<span class=\"" + std::string(name) + "\"";
  for (std::size_t at = 0; (at = body.find(opening, at)) != std::string_view::npos;) {
    const std::size_t begin = body.find('>', at), end = body.find("</span>", at);
    if (begin == std::string_view::npos || end == std::string_view::npos || end < begin) break;
    if (out.size() == bounds::kEventLogEntries * 4) break;
    out.push_back(plain_text(body.substr(begin + 1, std::min(end - begin - 1, kMostValue))));
    at = end;
  }
  return out;
}

std::string rws_value(std::string_view body, std::string_view name) {
  const auto values = rws_values(body, name);
  return values.empty() ? "" : values.front();
}

std::vector<RwsEvent> rws_events(std::string_view body) {
  std::vector<RwsEvent> out;
  constexpr std::string_view kEntry = "<li class=\"elog-message-li\" title=\"/rw/elog/";
  for (std::size_t at = 0;
       (at = body.find(kEntry, at)) != std::string_view::npos && out.size() < bounds::kEventLogEntries;) {
    const std::size_t next = body.find(kEntry, at + 1);
    const std::string_view entry = body.substr(at, next == std::string_view::npos ? next : next - at);
    const std::size_t quote = entry.find('"', kEntry.size());
    const std::string_view title = entry.substr(0, quote);
    const auto number = [](std::string_view text) { return parse_number(std::string(text)); };
    const auto whole = [](std::optional<double> n) {
      return n && *n >= 0 && *n <= 1e9 ? static_cast<int>(*n) : 0;
    };
    RwsEvent event;
    event.sequence = whole(number(title.substr(title.rfind('/') + 1)));
    event.kind = whole(number(rws_value(entry, "msgtype")));
    event.code = whole(number(rws_value(entry, "code")));
    event.title = rws_value(entry, "title");
    if (event.sequence > 0 && event.code > 0) out.push_back(std::move(event));
    at += kEntry.size();
  }
  return out;
}

bool Rws::fail(const wire::HttpMessage& answer, const std::string& what) {
  const std::string said = rws_value(answer.body, "msg");
  const std::string text = said.empty() ? what : what + ": " + said;
  Cause cause = Cause::rws_refused;
  if (answer.status == 401) cause = Cause::login;
  if (answer.status == 403)
    cause = said.find("astership") != std::string::npos ? Cause::mastership : Cause::forbidden;
  if (answer.status == 503) cause = Cause::busy;
  if (answer.status == 406 || answer.status == 415) cause = Cause::other_version;
  failure_ = {cause, cause == Cause::other_version ? 3 - settings_.version : answer.status, text};
  return false;
}

std::optional<wire::HttpMessage> Rws::ask(const std::string& method, const std::string& path,
                                          const std::string& body, const std::string& what) {
  failure_ = {};
  const Nanoseconds next = last_ + settings_.interval;
  for (Nanoseconds now; (now = realtime::monotonic_now()) < next;) wire::wait_readable(-1, next - now);
  wire::HttpMessage request;
  request.method = method;
  request.target = path;
  request.body = body;
  const std::string version = second() ? ";v=2.0" : "";
  request.headers.emplace_back("Accept", second() ? "application/xhtml+xml;v=2.0" : "application/xhtml+xml");
  if (method == "POST")
    request.headers.emplace_back("Content-Type", "application/x-www-form-urlencoded" + version);
  if (method == "PUT") request.headers.emplace_back("Content-Type", "text/plain" + version);
  auto answer = http_.ask(request);
  last_ = realtime::monotonic_now();
  if (!answer)
    failure_ = {cause_of(http_.failure()), 0,
                http_.failure() == wire::HttpClient::Failure::silent ||
                        http_.failure() == wire::HttpClient::Failure::bad_answer
                    ? what + ": " + http_.why()
                    : http_.why()};
  return answer;
}

std::optional<std::string> Rws::get(const std::string& path, const std::string& what) {
  auto answer = ask("GET", path, "", what);
  if (!answer) return std::nullopt;
  if (answer->status != 200) {
    fail(*answer, what);
    return std::nullopt;
  }
  return std::move(answer->body);
}

bool Rws::post(const std::string& path, const std::string& form, const std::string& what) {
  const auto answer = ask("POST", path, form, what);
  if (!answer) return false;
  return answer->status / 100 == 2 ? true : fail(*answer, what);
}

bool Rws::identify(RwsIdentity& out) {
  const auto system = get("/rw/system", "the software version");
  if (!system) return false;
  out.software = rws_value(*system, "rwversionname");
  if (out.software.empty()) out.software = rws_value(*system, "rwversion");
  out.options = rws_values(*system, "option");
  if (out.options.empty()) {
    const auto options = get("/rw/system/options", "the options");
    if (!options) return false;
    out.options = rws_values(*options, "option");
  }
  if (!out.software.empty()) return true;
  failure_ = {Cause::rws_bad_data, 0, "the software version"};
  return false;
}

bool Rws::read_state(RwsState& out) {
  const auto control =
      get(second() ? "/rw/panel/ctrl-state" : "/rw/panel/ctrlstate", "the state of the motors");
  if (!control) return false;
  const auto mode = get("/rw/panel/opmode", "the mode");
  if (!mode) return false;
  const auto program = get("/rw/rapid/execution", "the state of the program");
  if (!program) return false;
  const auto ratio = get("/rw/panel/speedratio", "the speed ratio");
  if (!ratio) return false;
  out.control = rws_value(*control, "ctrlstate");
  out.mode = rws_value(*mode, "opmode");
  out.program = rws_value(*program, "ctrlexecstate");
  out.speed_ratio = std::clamp(parse_number(rws_value(*ratio, "speedratio")).value_or(100), 0.0, 100.0) / 100;
  if (!out.control.empty() && !out.mode.empty() && !out.program.empty()) return true;
  failure_ = {Cause::rws_bad_data, 0, "the states of the panel"};
  return false;
}

std::optional<std::array<double, 6>> Rws::joints() {
  const auto body = get("/rw/motionsystem/mechunits/ROB_1/jointtarget", "the joints");
  if (!body) return std::nullopt;
  std::array<double, 6> out{};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = parse_number(rws_value(*body, "rax_" + std::to_string(i + 1)));
    if (!value || !std::isfinite(*value)) {
      failure_ = {Cause::rws_bad_data, 0, "the joints"};
      return std::nullopt;
    }
    out[i] = *value;
  }
  return out;
}

bool Rws::has_module(const std::string& task, const std::string& module) {
  const auto body = get(second() ? "/rw/rapid/tasks/" + wire::form_text(task) + "/modules"
                                 : "/rw/rapid/modules?task=" + wire::form_text(task),
                        "the modules of the task " + task);
  if (!body) return false;
  const auto names = rws_values(*body, "name");
  if (std::find(names.begin(), names.end(), module) != names.end()) return true;
  failure_ = {Cause::no_module, 0, task};
  return false;
}

bool Rws::motors(bool on) {
  return post(second() ? "/rw/panel/ctrl-state" : "/rw/panel/ctrlstate?action=setctrlstate",
              std::string("ctrl-state=") + (on ? "motoron" : "motoroff"), "to switch the motors");
}

template <typename Work>
bool Rws::as_master(Work work) {
  const std::string base = second() ? "/rw/mastership/edit/" : "/rw/mastership/rapid?action=";
  if (!post(base + "request", "", "the mastership")) return false;
  const bool done = work();
  const Failure why = failure_;
  const bool released = post(base + "release", "", "to release the mastership");
  if (!done) failure_ = why;
  return done && released;
}

bool Rws::reset_pointer() {
  return as_master([&] {
    return post(second() ? "/rw/rapid/execution/resetpp" : "/rw/rapid/execution?action=resetpp", "",
                "to set the program pointer to main");
  });
}

bool Rws::start_program(bool forever) {
  const std::string cycle = forever ? "forever" : "once";
  return post(second() ? "/rw/rapid/execution/start" : "/rw/rapid/execution?action=start",
              "regain=continue&execmode=continue&cycle=" + cycle +
                  "&condition=none&stopatbp=disabled&alltaskbytsp=false",
              "to start the program");
}

bool Rws::stop_program() {
  return post(second() ? "/rw/rapid/execution/stop" : "/rw/rapid/execution?action=stop",
              second() ? "stopmode=stop&usetsp=normal" : "stopmode=stop", "to stop the program");
}

bool Rws::set_speed_ratio(double share) {
  const auto percent = std::to_string(std::lround(std::clamp(share, 0.0, 1.0) * 100));
  return as_master([&] {
    return post(second() ? "/rw/panel/speedratio" : "/rw/panel/speedratio?action=setspeedratio",
                "speed-ratio=" + percent, "the speed ratio");
  });
}

std::optional<bool> Rws::signal(const std::string& name) {
  const auto body = get(signal_path(name), "the signal " + name);
  if (!body) {
    if (failure_.cause == Cause::rws_refused && (failure_.detail == 404 || failure_.detail == 400))
      failure_ = {Cause::no_signal, 0, name};
    return std::nullopt;
  }
  const std::string value = rws_value(*body, "lvalue");
  if (value == "0" || value == "1") return value == "1";
  failure_ = {Cause::rws_bad_data, 0, "the signal " + name};
  return std::nullopt;
}

bool Rws::set_signal(const std::string& name, bool on) {
  if (post(signal_path(name) + (second() ? "/set-value" : "?action=set"), on ? "lvalue=1" : "lvalue=0",
           "the signal " + name))
    return true;
  if (failure_.cause == Cause::forbidden || failure_.cause == Cause::mastership)
    failure_ = {Cause::signal_refused, 0, name};
  if (failure_.cause == Cause::rws_refused && failure_.detail == 404) failure_ = {Cause::no_signal, 0, name};
  return false;
}

std::optional<std::vector<RwsEvent>> Rws::events(long after) {
  const auto body = get("/rw/elog/0?lang=en&order=lifo&limit=25", "the event log");
  if (!body) return std::nullopt;
  auto out = rws_events(*body);
  std::erase_if(out, [&](const RwsEvent& event) { return event.sequence <= after; });
  std::sort(out.begin(), out.end(),
            [](const RwsEvent& a, const RwsEvent& b) { return a.sequence > b.sequence; });
  return out;
}

bool Rws::put_file(const std::string& name, const std::string& text) {
  const std::string path = (second() ? "/fileservice/HOME/" : "/fileservice/$home/") + wire::form_text(name);
  const auto answer = ask("PUT", path, text, "to write the file " + name);
  if (!answer) return false;
  return answer->status / 100 == 2 ? true : fail(*answer, "to write the file " + name);
}

bool Rws::load_module(const std::string& task, const std::string& file) {
  const std::string place = "/rw/rapid/tasks/" + wire::form_text(task);
  return as_master([&] {
    return post(place + (second() ? "/loadmod" : "?action=loadmod"),
                "modulepath=" + wire::form_text((second() ? "HOME/" : "$HOME/") + file) + "&replace=true",
                "to load the module " + file);
  });
}

bool Rws::log_out() {
  const bool done = get("/logout", "to log out").has_value();
  http_.close();
  return done;
}

}  // namespace polyarm::abb
