#include "polyarm/server/sessions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "polyarm/access/token.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/cell/known_cells.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/protocol/tags.hpp"
#include "polyarm/protocol/wire.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/server/control.hpp"
#include "polyarm/server/documents.hpp"
#include "polyarm/server/events.hpp"
#include "polyarm/server/jog_watch.hpp"
#include "polyarm/server/seats.hpp"
#include "polyarm/server/state_frames.hpp"

namespace polyarm::server {

namespace {
constexpr double kStatusEvery = 0.1, kLogEvery = 0.1;

using protocol::Any;
using protocol::Role;
}  // namespace

class Sessions::Work {
 public:
  Work(cell::Observer& next, std::string version, users::AuditLog* audit)
      : journal(next), version_(std::move(version)), audit_(audit) {}

  std::shared_ptr<Client> welcome(Client::Side side) { return seats_.welcome(std::move(side), rope); }

  void attach(cell::CellView& cell) {
    cell_ = &cell;
    jogs_.emplace(cell.held_motions(),
                  [this](std::uint64_t to, const std::string& line) { seats_.tell(to, line); });
    frames_.emplace(cell, ++layout_);
    events_.emplace(cell);
    status_.clear();
    for (auto& [number, seat] : seats_.all()) seat.greeted = false;
  }

  void detach() {
    if (!cell_) return;
    const Error gone("no-cell", "the cell was closed or restarted before it answered", "ask again");
    for (const auto& [number, seat] : seats_.all()) cell_->requests().refuse(seat.client.get(), gone);
    cell_ = nullptr;
    jogs_.reset();
    frames_.reset();
    events_.reset();
    status_.clear();
  }

  bool serve() {
    renew_budget(realtime::monotonic_now());
    take_lines();
    if (jogs_) jogs_->tick();
    control_.tick(now_);
    report_control();
    report_events_of_cell();
    send_frames();
    return seats_.any_woken();
  }

  bool take() {
    take_lines();
    return seats_.any_woken();
  }

  Pendant::Counts counts() const {
    Pendant::Counts out;
    out.clients = seats_.size();
    out.requests = requests;
    out.frames = frames_sent_;
    out.omitted_frames = seats_.omitted_frames();
    out.omitted_events = seats_.omitted_events();
    return out;
  }

  std::optional<users::Actor> actor(const void* client) const {
    for (const auto& [number, seat] : seats_.all())
      if (seat.client.get() == client) return seat.client->actor(seat.name);
    return std::nullopt;
  }

  Journal journal;
  std::uint64_t requests = 0;
  std::optional<cell::RestartRequest> wish;
  const std::shared_ptr<realtime::WakeupHandle> rope = std::make_shared<realtime::WakeupHandle>();

 private:
  // --- coming and going

  void check_clients() {
    seats_.seat_arrivals(now_);
    take_urgent();  // of those who leave, too: a stop counts, whoever sent it
    for (auto& [number, seat] : seats_.all()) {
      keep_seats_for_control(seat);
      end_with_login(*seat.client);
    }
    seats_.free_seats([this](const Seat& seat) {
      if (jogs_) jogs_->end_all(seat.client->number, "gone");
      control_.gone(seat.client->number);
    });
  }

  /// A connection of a user ends with the log-in; until then it renews it.
  void end_with_login(Client& client) {
    if (!client.login) return;
    if (client.login->over)
      client.leave();
    else
      client.login->used = now_;
  }

  /// Disconnects a client that uses a reserved seat but neither has control nor asks for it.
  void keep_seats_for_control(Seat& seat) {
    const std::uint64_t number = seat.client->number;
    if (seat.reserved_until == 0) return;
    if (control_.holds(number) || control_.asker() == number)
      seat.reserved_until = now_ + bounds::kControlSeat_ms / 1000.0;
    else if (now_ > seat.reserved_until)
      seat.client->leave();
  }

  // --- requests

  /// Takes the stops, holds and heartbeats of all clients first (check_clients). Then takes one line from
  /// each client in turn, up to the tick's limits of lines and time.
  void take_lines() {
    now_ = seconds(realtime::monotonic_now());
    if (cell_) journal.set_now(cell_->now());
    check_clients();
    const Nanoseconds begun = realtime::monotonic_now();
    if (begun - budget_since_ >= kBudgetEvery) renew_budget(begun);
    Nanoseconds taken = 0;
    bool first = true;  // one line is always taken, even if the time is used up
    for (std::size_t empty = 0;
         empty < seats_.size() && lines_left_ > 0 && (first || taken < time_left_);) {
      Seat& seat = seats_.next();
      const auto line = seat.client->line();
      empty = line ? 0 : empty + 1;
      if (!line) continue;
      first = false;
      --lines_left_;
      take(seat, *line);
      taken = realtime::monotonic_now() - begun;
    }
    time_left_ -= taken;
  }

  /// The budget of one tick and of the calls until the next.
  void renew_budget(Nanoseconds now) {
    budget_since_ = now;
    lines_left_ = bounds::kLinesATick;
    time_left_ = Nanoseconds{bounds::kTakeTime_us} * 1000;
  }

  void take_urgent() {
    for (auto& [number, seat] : seats_.all())
      for (std::string& line : seat.client->urgent()) take(seat, {std::move(line), false, false});
  }

  void take(Seat& seat, const Client::Line& line) {
    ++requests;
    Any id, fields;
    const protocol::RequestType* type = nullptr;
    try {
      const bool holds = control_.holds(seat.client->number);
      if (!holds && line.text.size() > bounds::kWatcherRequestBytes)
        throw Error("too-long",
                    "a request without control may have " + std::to_string(bounds::kWatcherRequestBytes) +
                        " bytes",
                    "take control first: session.take");
      fields = protocol::parse_request(line.text);
      const auto name = fields.json().find("request");
      if (name == fields.json().end() || !name->is_string())
        throw Error("bad-request", "a request is one JSON object with the text 'request'",
                    "for example {\"id\": 1, \"request\": \"control.list\"}");
      id = protocol::request_id(fields);
      type = protocol::find_request(name->get<std::string>());
      if (type) {
        require_may(seat, *type, fields);
        line.require_not_overtaken(*type, fields);
      }
      if (type && (type->facts->session || !cell_)) {
        const protocol::Request request = protocol::read_request(*type, fields);
        if (type->facts->session)
          take_own(seat, id, request);
        else
          without_cell(seat, id, request);
        // A step becomes a request of the cell, and is logged as that.
        if (type->facts != &protocol::JogStep::kFacts) log(seat, type, fields, nullptr);
        return;
      }
      pass_on(seat, id, type, fields, line.text.size());
    } catch (const Error& e) {
      seat.client->answer(protocol::refusal_line(e, id));
      log(seat, type, fields, &e);
    }
  }

  /// Writes a request to the audit log that the cell does not see: one of the port itself, or one that was
  /// refused here.
  void log(const Seat& seat, const protocol::RequestType* type, const Any& fields,
           const Error* refused) const {
    if (!audit_ || !type || !users::is_audited(*type, fields)) return;
    users::AuditEntry entry;
    if (cell_) entry.cell = cell_->file().name;
    entry.actor = seat.client->actor(seat.name);
    entry.request = type->facts->name;
    entry.arguments = users::arguments_text(fields);
    entry.outcome = refused ? refused->problems().front().code : "done";
    if (refused) entry.what = refused->problems().front().what;
    audit_->add(std::move(entry));
  }

  /// Reading needs no control. Any other request needs control, and a link whose role allows it.
  void require_may(const Seat& seat, const protocol::RequestType& type, const Any& fields) const {
    const std::string name = type.facts->name;
    const bool takes = type.facts == &protocol::SessionTake::kFacts;
    const Role needed = takes ? Role::operate : protocol::role_needed(type, fields);
    seat.client->require_role(needed, name);
    if (needed != Role::watch && !takes) require_control(seat, name);
  }

  void require_control(const Seat& seat, const std::string& what) const {
    if (control_.holds(seat.client->number)) return;
    const std::string who =
        control_.holder() ? "'" + seats_.name_of(control_.holder()) + "' has control" : "nobody has control";
    throw Error("no-control", "'" + what + "' is refused: " + who, "take control first: session.take");
  }

  void require_cell() const {
    if (!cell_) throw Error("no-cell", "no cell is running now", "wait until it has started again");
  }

  template <class R>
  static void answer(Seat& seat, const Any& id, typename R::Answer result) {
    seat.client->answer(protocol::result_line(protocol::Answer::of<R>(std::move(result)).any(), id));
  }

  /// Passes the request on to the cell. `by` is set to the client's name here, so that a client cannot claim
  /// another's.
  void pass_on(Seat& seat, const Any& id, const protocol::RequestType* type, const Any& fields,
               std::size_t bytes) {
    require_cell();
    const bool names_asker = type && (type->facts == &protocol::TagsSet::kFacts ||
                                      type->facts == &protocol::TagsForce::kFacts ||
                                      type->facts == &protocol::TagsRelease::kFacts ||
                                      type->facts == &protocol::FilesDraft::kFacts);
    Json request = fields.json();
    if (names_asker) request["by"] = seats_.name_of(seat.client->number);
    cell_->requests().handle(
        Any(std::move(request)), bytes,
        [client = seat.client,
         notes = type && type->facts == &protocol::WatchEvents::kFacts](const std::string& text) {
          return client->answer(notes ? without_tokens(text)
                                      : text);  // links in notes would give their role away
        },
        seat.client.get());
  }

  /// The few requests that work without a cell, when it has failed or could not be built.
  void without_cell(Seat& seat, const Any& id, const protocol::Request& request) {
    const protocol::Facts* const facts = &request.facts();
    if (facts == &protocol::CellsList::kFacts) return answer<protocol::CellsList>(seat, id, cell::known_cells({}));
    if (facts == &protocol::CellReach::kFacts) {
      const auto& asked = request.as<protocol::CellReach>();
      return answer<protocol::CellReach>(
          seat, id,
          cell::reach_of_cell({}, asked.folder.value_or(""), asked.allow.value_or(protocol::Names{})));
    }
    if (facts == &protocol::CellRestart::kFacts) {
      const auto& asked = request.as<protocol::CellRestart>();
      begin_restart({asked.robot.value_or(""), asked.hardware.value_or(""), asked.program.value_or(""),
                  asked.cell.value_or("")});
    } else if (facts == &protocol::CellConnect::kFacts) {
      begin_restart({{}, {}, {}, {}, request.as<protocol::CellConnect>().real});
    } else {
      require_cell();
    }
    answer<protocol::CellRestart>(seat, id, {"restart"});
  }

  /// Passes a request on to the cell, with this client's id.
  void hand_over(Seat& seat, const Any& id, protocol::Request request) {
    cell_->requests().ask(
        std::move(request),
        [client = seat.client, id](const protocol::Reply& reply) {
          return client->answer(protocol::reply_line(reply, id));
        },
        seat.client.get());
  }

  // --- requests of a session

  /// One function per request. Requests that are answered later return nothing.
  void take_own(Seat& seat, const Any& id, const protocol::Request& request) {
    using namespace protocol;
    const protocol::Facts* const facts = &request.facts();
    if (facts == &SessionHello::kFacts) return answer<SessionHello>(seat, id, hello(seat, request.as<SessionHello>()));
    if (facts == &SessionWatch::kFacts) return answer<SessionWatch>(seat, id, watch(seat, request.as<SessionWatch>()));
    if (facts == &SessionEnd::kFacts) return answer<SessionEnd>(seat, id, end_request(seat, request.as<SessionEnd>()));
    if (facts == &SessionTake::kFacts) return answer<SessionTake>(seat, id, take_control(seat, request.as<SessionTake>()));
    if (facts == &SessionRelease::kFacts) return answer<SessionRelease>(seat, id, release(seat));
    if (facts == &SessionAnswer::kFacts) return answer<SessionAnswer>(seat, id, answer_asker(seat, request.as<SessionAnswer>()));
    if (facts == &JogBeat::kFacts) return beat(seat, request.as<JogBeat>());
    if (facts == &JogEnd::kFacts) return answer<JogEnd>(seat, id, jog_end(seat, request.as<JogEnd>()));
    if (facts == &JogBegin::kFacts) return jog_begin(seat, id, request.as<JogBegin>());
    if (facts == &JogGoto::kFacts) return jog_goto(seat, id, request.as<JogGoto>());
    if (facts == &JogStep::kFacts) return jog_step(seat, id, request.as<JogStep>());
    if (facts == &CellChange::kFacts) return answer<CellChange>(seat, id, change_cell(request.as<CellChange>()));
    if (facts == &CellOpen::kFacts) return answer<CellOpen>(seat, id, change_cell(request.as<CellOpen>()));
    if (facts == &CellReset::kFacts) return answer<CellReset>(seat, id, change_cell(request.as<CellReset>()));
  }

  /// Ends one running request of this client, as if the client had disconnected.
  protocol::Nothing end_request(Seat& seat, const protocol::SessionEnd& request) {
    if (cell_) cell_->requests().end(seat.client.get(), request.of.value_or(Any{}));
    return {};
  }

  /// The cell's restart request with the names that the page's menus use.
  template <class Change>
  protocol::Asked change_cell(const Change& request) {
    cell::RestartRequest asked;
    const std::string robot = request.robot.value_or("");
    if (request.model) asked.robot = (robot.empty() ? "" : robot + "=") + *request.model;
    asked.cell = request.folder.value_or("");
    if (!cell_) {
      begin_restart(std::move(asked));
    } else {
      cell::require_within_reach(asked, cell_->file().folder);
      cell_->request_restart(std::move(asked));
    }
    return {"restart"};
  }

  /// Used while no cell runs.
  void begin_restart(cell::RestartRequest asked) {
    cell::require_within_reach(asked, {});
    wish = std::move(asked);
  }

  protocol::OrNull<protocol::ClientName> who(std::uint64_t client) const {
    protocol::OrNull<protocol::ClientName> out;
    if (client != 0) out.emplace(protocol::ClientName{client, seats_.name_of(client)});
    return out;
  }
  protocol::SessionHello::Answer hello(Seat& seat, const protocol::SessionHello& request) {
    if (request.name) seat.name = seat.client->shown_name(request.name->substr(0, bounds::kClientNameBytes));
    seat.listens = true;
    protocol::SessionHello::Answer out;
    out.client = seat.client->number;
    out.holder = who(control_.holder());
    out.you_hold = control_.holds(seat.client->number);
    out.version = version_;
    if (cell_) out.cell = cell_->file().name;
    out.local = seat.client->local;
    out.role = seat.client->role;
    return out;
  }

  protocol::SessionWatch::Answer watch(Seat& seat, const protocol::SessionWatch& request) {
    const double rate = request.rate.value_or(30.0);
    if (!(rate >= 0 && rate <= 1000))
      throw Error("bad-argument", "'rate' is not a number of frames a second", "0 to 60");
    const bool news = seat.rate == 0 && rate > 0;
    seat.rate = std::min(rate, kFastest);
    seat.listens = true;
    if (news && frames_ && seat.greeted) seat.client->put(Kind::layout, frames_->layout());
    return {seat.rate};
  }

  protocol::SessionTake::Answer take_control(Seat& seat, const protocol::SessionTake& request) {
    const std::uint64_t client = seat.client->number;
    if (request.force && !seat.client->local && control_.holder() != 0)
      throw Error("no-force", "only a client on this machine can take control without asking",
                  "ask: session.take");
    const std::uint64_t before = control_.holder();
    const Control::Taken taken = control_.take(client, request.force, now_);
    if (taken == Control::Taken::others)
      throw Error("asked-already", "'" + seats_.name_of(control_.asker()) + "' has asked for control already",
                  "wait a moment");
    if (taken == Control::Taken::yes && before != 0 && before != client && jogs_)
      jogs_->end_all(before, "control");
    return {taken == Control::Taken::yes, who(control_.holder()), control_.left(now_)};
  }

  protocol::ControlHolder release(Seat& seat) {
    if (jogs_) jogs_->end_all(seat.client->number, "control");
    control_.release(seat.client->number);
    return {false, who(control_.holder())};
  }

  protocol::ControlHolder answer_asker(Seat& seat, const protocol::SessionAnswer& request) {
    if (!control_.answer(seat.client->number, request.give))
      throw Error("not-asked", "no client asks you for control");
    if (request.give && jogs_) jogs_->end_all(seat.client->number, "control");
    return {control_.holds(seat.client->number), who(control_.holder())};
  }

  /// The answer follows when the robot moves.
  void jog_begin(Seat& seat, const Any& id, const protocol::JogBegin& request) {
    require_cell();
    jogs_->begin(seat.client->number, id, request);
  }

  /// With `dry` the path is only planned; else the robot moves along it while heartbeats come.
  void jog_goto(Seat& seat, const Any& id, const protocol::JogGoto& request) {
    require_cell();
    if (request.dry)
      hand_over(seat, id, way_of(request));
    else
      jogs_->go_to(seat.client->number, id, request);
  }

  void beat(Seat& seat, const protocol::JogBeat& request) {
    const Any named = request.jog.value_or(Any{});
    const Json& jog = named.json();
    if (jogs_ && jog.is_number_unsigned()) jogs_->beat(seat.client->number, jog.get<std::uint64_t>());
  }

  protocol::Nothing jog_end(Seat& seat, const protocol::JogEnd& request) {
    require_cell();
    if (request.jog)
      jogs_->end(seat.client->number, *request.jog, "released");
    else
      jogs_->end_all(seat.client->number, "released");
    return {};
  }

  /// The cell answers.
  void jog_step(Seat& seat, const Any& id, const protocol::JogStep& request) {
    require_cell();
    hand_over(seat, id, jogs_->step(request));
  }

  // --- reporting

  void report_control() {
    for (const ControlReport& news : control_.take_reports()) {
      constexpr const char* kWhats[] = {"asked", "given", "refused", "taken", "lost", "free"};
      if (jogs_ && (news.what == ControlReport::What::lost || news.what == ControlReport::What::taken))
        jogs_->end_all(news.to, "control");
      const bool asked = news.what == ControlReport::What::asked;
      const Json event{{"event", asked ? "asked" : "control"},
                       {"what", kWhats[static_cast<std::size_t>(news.what)]},
                       {"client", news.other},
                       {"name", seats_.name_of(news.other)},
                       {"seconds", asked ? Json(control_.left(now_)) : Json()},
                       {"you_hold", control_.holds(news.to)}};
      if (news.to != 0) seats_.tell(news.to, dump(event));
    }
  }

  void broadcast(Kind kind, const Text& text, const std::function<Text()>& whole = {}) {
    if (!text) return;
    Text all;
    for (auto& [number, seat] : seats_.all()) {
      if (!seat.listens || !seat.greeted) continue;
      if (whole && seat.client->waits(kind)) {
        if (!all) all = whole();
        if (all) seat.client->put(kind, all);
      } else {
        seat.client->put(kind, text);
      }
    }
  }

  std::string status() {
    if (cell_) return status_line(status_of(*cell_, journal));
    return status_line(protocol::NoCellStatus{});
  }
  template <class Status>
  std::string status_line(Status status) {
    status.holder = who(control_.holder());
    status.asker = who(control_.asker());
    status.clients = seats_.size();
    return protocol::any_of(status).dump();
  }

  void report_events_of_cell() {
    const bool anybody = std::any_of(seats_.all().begin(), seats_.all().end(),
                                     [](const auto& each) { return each.second.listens; });
    if (!anybody) return;
    const std::uint64_t key =
        cell_ ? (static_cast<std::uint64_t>(cell_->snapshot().state) << 8) + control_.holder() : ~0ull;
    if (is_due(sent_status_, kStatusEvery, now_) || key != status_key_) {
      status_key_ = key;
      std::string text = status();
      if (text != status_) {
        status_ = std::move(text);
        broadcast(Kind::status, std::make_shared<const std::string>(status_));
      }
    }
    if (is_due(sent_log_, kLogEvery, now_) && journal.last_line() != lines_reported_) {
      broadcast(Kind::log, log_event(journal, lines_reported_));
      lines_reported_ = journal.last_line();
    }
    for (const Journal::Alarm& alarm : journal.alarms())
      if (alarm.number > alarms_sent_) broadcast(Kind::log, alarm_event(alarm));
    alarms_sent_ = journal.last_alarm();
    if (events_)
      events_->report(now_, [this](Kind kind, const Text& text, const std::function<Text()>& whole) {
        broadcast(kind, text, whole);
      });
    for (auto& [number, seat] : seats_.all())
      if (seat.listens && !std::exchange(seat.greeted, true)) greet(seat);
  }

  /// Sends the full state to a client that has just connected.
  void greet(Seat& seat) {
    const auto put = [&](Kind kind, const Text& text) {
      if (text) seat.client->put(kind, text);
    };
    put(Kind::status, std::make_shared<const std::string>(status_.empty() ? status() : status_));
    put(Kind::log, log_event(journal, 0));
    for (const Journal::Alarm& alarm : journal.alarms()) put(Kind::log, alarm_event(alarm));
    if (!cell_) return;
    if (seat.rate > 0) put(Kind::layout, frames_->layout());
    events_->greet(put);
  }

  void send_frames() {
    if (!frames_) return;
    Text frame;
    for (auto& [number, seat] : seats_.all()) {
      if (seat.rate <= 0 || !seat.greeted || now_ < seat.due) continue;
      // All clients of one rate are due in the same tick: one frame is made, and the I/O thread is woken
      // once.
      seat.due = (std::floor(now_ * seat.rate) + 1) / seat.rate;
      if (!frame) frame = frames_->frame();
      seat.client->put_state(frame);
      ++frames_sent_;
    }
  }

  std::string version_;
  users::AuditLog* audit_;

  cell::CellView* cell_ = nullptr;
  double now_ = 0;
  Seats seats_;
  static constexpr Nanoseconds kBudgetEvery = 2'000'000;  // one tick
  std::size_t lines_left_ = 0;                            // left in the budget
  Nanoseconds time_left_ = 0, budget_since_ = 0;
  Control control_;
  std::optional<JogWatch> jogs_;
  std::optional<StateFrames> frames_;
  std::optional<CellEvents> events_;
  std::uint16_t layout_ = 0;
  std::string status_;
  std::uint64_t status_key_ = 0, lines_reported_ = 0, alarms_sent_ = 0;
  double sent_status_ = 0, sent_log_ = 0;
  std::uint64_t frames_sent_ = 0;
};

Sessions::Sessions(cell::Observer& next, std::string version, users::AuditLog* audit)
    : work_(std::make_unique<Work>(next, std::move(version), audit)) {}
Sessions::~Sessions() = default;
std::shared_ptr<Client> Sessions::welcome(Client::Side side) {
  return work_->welcome(std::move(side));
}
Journal& Sessions::journal() {
  return work_->journal;
}
void Sessions::attach(cell::CellView& cell) {
  work_->attach(cell);
}
void Sessions::detach() {
  work_->detach();
}
bool Sessions::serve() {
  return work_->serve();
}
bool Sessions::take() {
  return work_->take();
}
void Sessions::set_wakeup(const std::shared_ptr<realtime::Bell>& bell) {
  work_->rope->tie(bell);
}
std::optional<cell::RestartRequest> Sessions::take_restart_request() {
  return std::exchange(work_->wish, std::nullopt);
}
std::optional<users::Actor> Sessions::actor(const void* client) const {
  return work_->actor(client);
}
Pendant::Counts Sessions::counts() const {
  return work_->counts();
}

}  // namespace polyarm::server
