#include "polyarm/cell/requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/problem_json.hpp"
#include "polyarm/cell/request_roles.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cell {

namespace {

using Row = RequestRow;

Poll help(Cell&, const Json&) {
  Json out = Json::array();
  for (const RequestInfo& info : request_table()) {
    Json arguments = Json::array();
    for (const RequestArgument& a : info.arguments)
      arguments.push_back({{"name", a.name}, {"type", name(a.type)}, {"needed", a.needed}});
    out.push_back({{"request", info.name},
                   {"arguments", arguments},
                   {"result", info.result},
                   {"text", info.text},
                   {"moves", info.moves}});
  }
  return at_once(std::move(out));
}

/// The whole table.
const std::vector<Row>& rows() {
  static const std::vector<Row> table = [] {
    std::vector<Row> out = {
        {{"help", {}, "[{request, arguments, result, text, moves}]", "this table", false}, help}};
    for (const auto family : {controller_rows, motion_rows, tag_rows, hardware_rows, health_rows,
                              message_rows, jog_rows, move_rows, load_rows, program_rows, record_rows,
                              point_rows, frame_rows, preview_rows, file_rows, text_rows, cells_rows, connect_rows})
      out.insert(out.end(), family().begin(), family().end());
    return out;
  }();
  return table;
}

Json error_json(const Error& error) {
  Json all = Json::array();
  for (const Problem& problem : error.problems()) {
    if (all.size() >= bounds::kErrorProblems) break;
    all.push_back(problem_json(problem));
  }
  Json out = all.front();
  if (all.size() > 1) out["all"] = all;
  return out;
}

}  // namespace

const std::vector<RequestInfo>& request_table() {
  static const std::vector<RequestInfo> table = [] {
    std::vector<RequestInfo> out;
    for (const Row& row : rows()) out.push_back(row.info);
    return out;
  }();
  return table;
}

bool knows_request(const std::string& name) {
  const auto& table = rows();
  return std::any_of(table.begin(), table.end(), [&](const Row& row) { return name == row.info.name; });
}

Json request_id(const Json& request) {
  const auto id = request.find("id");
  if (id == request.end()) return {};
  const bool is_long = !id->is_number() &&
                       id->dump(-1, ' ', false, Json::error_handler_t::replace).size() > bounds::kRequestIdBytes;
  if (is_long)
    throw Error("bad-request", fmt::format("the 'id' has more than {} bytes", bounds::kRequestIdBytes));
  return *id;
}

const char* name(ArgumentType type) {
  constexpr const char* kTypes[] = {"text", "number", "flag", "names", "map", "message", "any"};
  return kTypes[static_cast<std::size_t>(type)];
}

std::string request_reference() {
  std::string out = "| request | arguments | result | what it does | may move |\n|---|---|---|---|---|\n";
  for (const RequestInfo& info : request_table()) {
    std::vector<std::string> arguments;
    for (const RequestArgument& a : info.arguments)
      arguments.push_back("`" + std::string(a.name) + "`" + (a.needed ? "" : "?") + ": " + name(a.type));
    out += "| `" + std::string(info.name) + "` | " + join(arguments, ", ") + " | `" + info.result + "` | " +
           info.text + " | " + (info.moves ? "yes" : "") + " |\n";
  }
  return out;
}

Poll then_with(Poll first, std::function<Poll(Cell&, Json)> second) {
  return [first = std::move(first), second = std::move(second), next = Poll{}](Cell& cell) mutable {
    if (next) return next(cell);
    Progress progress = first(cell);
    if (!progress.over) return Progress{};
    next = second(cell, progress.answer ? std::move(*progress.answer) : Json());
    return next(cell);
  };
}

Poll then(Poll first, std::function<Poll(Cell&)> second) {
  return then_with(std::move(first),
                   [second = std::move(second)](Cell& cell, const Json&) { return second(cell); });
}

namespace {

const Row& row_of(const Json& request) {
  const std::string wanted = text_argument(request, "request");
  std::vector<std::string> known;
  for (const Row& row : rows()) {
    if (wanted == row.info.name) return row;
    known.emplace_back(row.info.name);
  }
  throw Error("unknown-request", "there is no request '" + wanted + "'" + did_you_mean(wanted, known),
              "`help` lists them");
}

}  // namespace

class Requests::Work {
 public:
  explicit Work(Cell& cell) : cell_(cell) {}

  void handle(const std::string& line, Answer answer, const void* from) {
    begin(as_text(std::move(answer)), from, line.size(), [&] { return parse_request(line); });
  }
  void handle(Json request, std::size_t bytes, Answer answer, const void* from) {
    ask(std::move(request), bytes, as_text(std::move(answer)), from);
  }
  void ask(Json request, std::size_t bytes, JsonAnswer answer, const void* from) {
    begin(std::move(answer), from, bytes, [&] { return std::move(request); });
  }

  void end(const void* from, const Json& id) {
    for (Open& each : open_)
      if (each.from == from && each.id == id && !id.is_null()) each.over = true;
  }

  /// All of few; of many those that there is time for, and the others in the ticks that follow.
  void tick() {
    const Nanoseconds until = realtime::monotonic_now() + kTickTime;
    const std::size_t first = first_ < open_.size() ? first_ : 0;
    first_ = 0;
    std::set<const void*> waited_for = askers_before(first);
    for (std::size_t n = 0; n < open_.size(); ++n) {
      const std::size_t i = (first + n) % open_.size();
      if (i == 0) waited_for.clear();
      if (n > kAlways && realtime::monotonic_now() > until) {
        first_ = i;
        break;
      }
      if (open_[i].over) continue;
      if (open_[i].begun || !open_[i].from || !waited_for.contains(open_[i].from))
        open_[i].over = advance(open_[i]);
      if (waits(open_[i])) waited_for.insert(open_[i].from);
    }
    sweep();
  }

  std::size_t open() const { return open_.size(); }

 private:
  struct Open {
    Json id, request;
    const Row* row = nullptr;
    JsonAnswer answer;
    const void* from = nullptr;
    std::size_t bytes = 0;
    Poll poll;
    std::optional<Json> refused;  // to be told when it is its turn
    bool begun = false, answered = false, over = false;
  };
  /// So many are looked at in each tick whatever time that takes; more for so long.
  static constexpr std::size_t kAlways = 32;
  static constexpr Nanoseconds kTickTime = 1'000'000;

  template <typename Parse>
  void begin(JsonAnswer answer, const void* from, std::size_t bytes, Parse parse) {
    Open open;
    open.answer = std::move(answer);
    open.from = from;
    open.bytes = bytes;
    guarded(open, [&] {
      open.request = parse();
      open.id = request_id(open.request);
      open.row = &row_of(open.request);
      check_arguments(open.request, open.row->info);
      require_room(open);
    });
    if (open.refused) {
      open.request = Json();
      open.bytes = 0;
    }
    // A refusal waits for its turn, too; a stop never waits.
    const bool urgent = open.row && open.row->urgent;
    if (urgent) overtake(from);
    if (!urgent && open_.size() < 2 * bounds::kOpenRequests && must_wait(from)) return keep(std::move(open));
    if (!advance(open)) keep(std::move(open));
  }

  /// What the same asker sent before its stop, and has not begun, must not move what was stopped.
  void overtake(const void* from) {
    for (Open& each : open_)
      if (from && each.from == from && !each.begun && !each.refused && each.row &&
          role_needed(each.row->info.name, each.request) == Role::operate)
        each.refused = error_json(Error(
            "overtaken",
            std::string("'") + each.row->info.name + "' is refused: a stop came after it and was taken first",
            "send it again if it is still wanted"));
  }

  void keep(Open open) {
    bytes_ += open.bytes;
    open_.push_back(std::move(open));
  }

  void sweep() {
    std::size_t before = 0;
    for (std::size_t i = 0; i < std::min(first_, open_.size()); ++i) before += open_[i].over ? 1 : 0;
    first_ -= before;
    std::erase_if(open_, [&](const Open& open) {
      if (open.over) bytes_ -= open.bytes;
      return open.over;
    });
  }

  /// Nobody's requests keep those of others out, until all are too many. Stops are begun at once.
  void require_room(const Open& open) const {
    if (open.row->urgent) return;
    const auto refuse = [](std::size_t most, const char* whose) {
      throw Error("busy", fmt::format("more than {} requests{} are open", most, whose),
                  "wait for answers, or end what goes on");
    };
    if (open_.size() >= bounds::kOpenRequests) refuse(bounds::kOpenRequests, "");
    if (bytes_ + open.bytes > bounds::kOpenRequestBytes)
      throw Error("busy", fmt::format("the requests that are open have more than {} bytes",
                                      bounds::kOpenRequestBytes),
                  "wait for answers");
    const auto own = [&](const Open& each) { return each.from == open.from; };
    if (open.from && static_cast<std::size_t>(std::count_if(open_.begin(), open_.end(), own)) >=
                         bounds::kOpenRequestsOfOne)
      refuse(bounds::kOpenRequestsOfOne, " of one connection");
  }

  /// Has one of the same asker to be answered before the next is begun?
  static bool waits(const Open& open) { return open.from && !open.answered && !open.over; }
  bool must_wait(const void* from) const {
    return from && std::any_of(open_.begin(), open_.end(),
                               [&](const Open& each) { return each.from == from && waits(each); });
  }
  std::set<const void*> askers_before(std::size_t place) const {
    std::set<const void*> out;
    for (std::size_t i = 0; i < place; ++i)
      if (waits(open_[i])) out.insert(open_[i].from);
    return out;
  }

  /// Runs `step`; what it throws becomes the refusal of the request.
  template <typename Step>
  static void guarded(Open& open, Step step) {
    try {
      step();
    } catch (const Error& e) {
      open.refused = error_json(e);
    } catch (...) {
      open.refused = error_json(Error("internal", "unexpected: " + what_was_thrown()));
    }
  }

  static bool send(Open& open, Json line) {
    open.answered = true;
    if (!open.id.is_null()) line["id"] = open.id;
    return open.answer(std::move(line));
  }
  static JsonAnswer as_text(Answer answer) {
    return [answer = std::move(answer)](const Json& line) {
      return answer(line.dump(-1, ' ', false, Json::error_handler_t::replace));
    };
  }

  /// True when it is over.
  bool advance(Open& open) {
    Progress progress;
    guarded(open, [&] {
      if (open.refused) return;
      if (!std::exchange(open.begun, true)) {
        open.poll = open.row->handler(cell_, open.request);
        open.request = Json();  // a goal stays open for long, and its points are many
      }
      progress = open.poll(cell_);
    });
    if (open.refused) {
      send(open, {{"ok", false}, {"error", *open.refused}});
      return true;
    }
    if (!progress.answer) return progress.over;
    Json line{{"ok", true}, {"result", std::move(*progress.answer)}};
    if (!progress.over) line["more"] = true;
    return !send(open, std::move(line)) || progress.over;
  }

  Cell& cell_;
  std::vector<Open> open_;
  std::size_t bytes_ = 0;  // of the requests in there
  std::size_t first_ = 0;  // where the next tick goes on
};

Requests::Requests(Cell& cell) : work_(std::make_unique<Work>(cell)) {}
Requests::~Requests() = default;
void Requests::handle(const std::string& line, Answer answer, const void* from) {
  work_->handle(line, std::move(answer), from);
}
void Requests::handle(nlohmann::json request, std::size_t bytes, Answer answer, const void* from) {
  work_->handle(std::move(request), bytes, std::move(answer), from);
}
void Requests::ask(nlohmann::json request, std::size_t bytes, JsonAnswer answer, const void* from) {
  work_->ask(std::move(request), bytes, std::move(answer), from);
}
void Requests::end(const void* from, const nlohmann::json& id) {
  work_->end(from, id);
}
void Requests::tick() {
  work_->tick();
}
std::size_t Requests::open() const {
  return work_->open();
}

}  // namespace polyarm::cell
