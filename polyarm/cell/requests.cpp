#include "polyarm/cell/requests.hpp"

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

namespace {

struct Row {
  RequestInfo info;
  Handler handler;
};

const std::vector<Row>& rows() {
  static const std::vector<Row> table = {
      {{"control.list", "", "the controllers: type, state, what they claim and offer", false}, control_list},
      {{"control.types", "", "the controller types that there are", false}, control_types},
      {{"control.chains", "", "which controllers work through which", false}, control_chains},
      {{"control.switch",
        "activate: [NAME], deactivate: [NAME], strictness: strict|best_effort|auto|force, dry",
        "start and stop controllers in one step; dry: only say what would happen", true},
       control_switch},
      {{"control.load", "name, type, parameters: {KEY: VALUE}", "make and configure a controller", false},
       control_load},
      {{"control.unload", "name", "take a controller away that is not active", false}, control_unload},
      {{"control.state", "name, state: unconfigured|inactive|active",
        "take a controller to a state, through all that lie between", true},
       control_state},
      {{"control.hold", "", "stop on the path", true}, control_hold},
      {{"control.stop", "", "stop at once", true}, control_stop},
      {{"control.resume", "", "go on after a hold", true}, control_resume},
      {{"control.discard", "", "forget what is left of a motion that is held", true}, control_discard},
      {{"control.recover", "", "leave the fault state; nothing moves yet", true}, control_recover},
      {{"hardware.list", "", "the hardware components: driver, state, interfaces", false}, hardware_list},
      {{"hardware.state", "name, state: unconfigured|inactive|active|finalized",
        "take a component to a state; controllers that use it are stopped first", true},
       hardware_state},
      {{"hardware.recover", "name", "bring a component back that has failed; no controller is started", true},
       hardware_recover},
      {{"interfaces", "", "every state and command interface: value, holder", false}, interfaces_list},
      {{"health", "", "cycles, lateness, cost, faults", false}, health},
      {{"limits", "", "which limits took hold of commands, how often, and the last time", false},
       limits_list},
      {{"param.list", "name", "the parameters of a controller: value, default, whether it can be changed",
        false},
       param_list},
      {{"param.get", "name, key", "one parameter", false}, param_get},
      {{"param.set", "name, values: {KEY: VALUE}", "change parameters between two cycles, all or none", true},
       param_set},
      {{"send", "to, message: TEXT, goal", "give a message to a controller; a goal is followed to its end",
        true},
       send_message},
      {{"goal.cancel", "to, goal: NUMBER", "end a goal", true}, goal_cancel},
      {{"watch", "name, rate: HZ", "tell what a controller puts out, again and again", false}, watch_output},
  };
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

std::string text_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || !found->is_string())
    throw Error("bad-argument", std::string("the request needs the text '") + name + "'");
  return found->get<std::string>();
}

std::string text_argument(const Json& arguments, const char* name, const std::string& fallback) {
  return arguments.contains(name) ? text_argument(arguments, name) : fallback;
}

std::vector<std::string> list_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return {};
  std::vector<std::string> out;
  if (found->is_string()) out.push_back(found->get<std::string>());
  if (found->is_array())
    for (const Json& item : *found)
      if (item.is_string()) out.push_back(item.get<std::string>());
  if (out.size() != (found->is_array() ? found->size() : 1))
    throw Error("bad-argument", std::string("'") + name + "' is no list of names");
  return out;
}

bool flag_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  return found != arguments.end() && found->is_boolean() && found->get<bool>();
}

double number_argument(const Json& arguments, const char* name, double fallback) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return fallback;
  if (!found->is_number()) throw Error("bad-argument", std::string("'") + name + "' is no number");
  return found->get<double>();
}

Poll then(Poll first, std::function<Poll(Cell&)> second) {
  return [first = std::move(first), second = std::move(second), next = Poll{}](Cell& cell) mutable {
    if (next) return next(cell);
    Progress progress = first(cell);
    if (!progress.over) return Progress{};
    next = second(cell);
    return next(cell);
  };
}

class Requests::Work {
 public:
  explicit Work(Cell& cell) : cell_(cell) {}

  void handle(const std::string& line, Answer answer) {
    Open open;
    open.answer = std::move(answer);
    try {
      open.poll = begin(line, open.id);
    } catch (const Error& e) {
      refuse(open, e);
      return;
    }
    if (!advance(open)) open_.push_back(std::move(open));
  }

  void tick() {
    for (std::size_t i = 0; i < open_.size();)
      if (advance(open_[i]))
        open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
  }

 private:
  struct Open {
    Json id;
    Answer answer;
    Poll poll;
  };

  Poll begin(const std::string& line, Json& id) {
    const Json request = Json::parse(line, nullptr, false);
    if (request.is_discarded() || !request.is_object())
      throw Error("bad-request", "a request is one JSON object a line",
                  "for example {\"request\": \"control.list\"}");
    if (request.contains("id")) id = request["id"];
    const std::string name = text_argument(request, "request");
    std::vector<std::string> known;
    for (const Row& row : rows()) {
      if (name == row.info.name) return row.handler(cell_, request);
      known.emplace_back(row.info.name);
    }
    throw Error("unknown-request", "there is no request '" + name + "'" + did_you_mean(name, known));
  }

  static bool send(Open& open, Json line) {
    if (!open.id.is_null()) line["id"] = open.id;
    return open.answer(line.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  static void refuse(Open& open, const Error& error) {
    send(open, {{"ok", false}, {"error", error_json(error)}});
  }

  /// True when it is over.
  bool advance(Open& open) {
    try {
      Progress progress = open.poll(cell_);
      if (!progress.answer) return progress.over;
      Json line{{"ok", true}, {"result", std::move(*progress.answer)}};
      if (!progress.over) line["more"] = true;
      return !send(open, std::move(line)) || progress.over;
    } catch (const Error& e) {
      refuse(open, e);
      return true;
    }
  }

  Cell& cell_;
  std::vector<Open> open_;
};

Requests::Requests(Cell& cell) : work_(std::make_unique<Work>(cell)) {}
Requests::~Requests() = default;
void Requests::handle(const std::string& line, Answer answer) {
  work_->handle(line, std::move(answer));
}
void Requests::tick() {
  work_->tick();
}

}  // namespace polyarm::cell
