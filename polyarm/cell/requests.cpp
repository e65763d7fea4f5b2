#include "polyarm/cell/requests.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

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
  for (const Problem& problem : error.problems())
    all.push_back({{"code", problem.code},
                   {"what", problem.what},
                   {"advice", problem.advice},
                   {"where", problem.where.text()}});
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
    Open open;
    open.answer = std::move(answer);
    open.from = from;
    guarded(open, [&] {
      open.request = parse_request(line);
      if (const auto id = open.request.find("id"); id != open.request.end()) open.id = *id;
      open.row = &row_of(open.request);
      check_arguments(open.request, open.row->info);
      if (open_.size() >= kMostOpen)
        throw Error("busy", "more than " + std::to_string(kMostOpen) + " requests are open",
                    "wait for answers, or end what goes on");
    });
    // A refusal waits for its turn, too; a stop never waits.
    const bool urgent = open.row && open.row->urgent;
    if (!urgent && open_.size() < 2 * kMostOpen && must_wait(open_.size(), from))
      return open_.push_back(std::move(open));
    if (!advance(open)) open_.push_back(std::move(open));
  }

  void tick() {
    for (std::size_t i = 0; i < open_.size(); ++i)
      if (open_[i].begun || !must_wait(i, open_[i].from)) open_[i].over = advance(open_[i]);
    std::erase_if(open_, [](const Open& open) { return open.over; });
  }

  std::size_t open() const { return open_.size(); }

 private:
  struct Open {
    Json id, request;
    const Row* row = nullptr;
    Answer answer;
    const void* from = nullptr;
    Poll poll;
    std::optional<Json> refused;  // to be told when it is its turn
    bool begun = false, answered = false, over = false;
  };

  /// Has somebody before place `i` from the same asker not been answered yet?
  bool must_wait(std::size_t i, const void* from) const {
    if (!from) return false;
    for (std::size_t k = 0; k < i; ++k)
      if (open_[k].from == from && !open_[k].answered && !open_[k].over) return true;
    return false;
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
    return open.answer(line.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  /// True when it is over.
  bool advance(Open& open) {
    Progress progress;
    guarded(open, [&] {
      if (open.refused) return;
      if (!std::exchange(open.begun, true)) open.poll = open.row->handler(cell_, open.request);
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
};

Requests::Requests(Cell& cell) : work_(std::make_unique<Work>(cell)) {}
Requests::~Requests() = default;
void Requests::handle(const std::string& line, Answer answer, const void* from) {
  work_->handle(line, std::move(answer), from);
}
void Requests::tick() {
  work_->tick();
}
std::size_t Requests::open() const {
  return work_->open();
}

}  // namespace polyarm::cell
