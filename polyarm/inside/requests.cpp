#include "polyarm/inside/requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/reference.hpp"
#include "polyarm/protocol/wire.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cell {

namespace {

using protocol::Any;
using protocol::Reply;
using protocol::Request;
using protocol::Role;

}  // namespace

class Requests::Work {
 public:
  Work(CellInside& cell, const std::vector<Handler>& handlers) : cell_(cell) {
    for (const Handler& handler : handlers) handlers_.emplace(handler.type, handler);
  }

  void ask(Request request, OnReply on_reply, const void* from, std::size_t bytes) {
    begin(std::move(on_reply), from, bytes, [&](Open& open) { open.request = std::move(request); });
  }

  template <class Parse>
  void handle(std::size_t bytes, OnLine on_line, const void* from, Parse parse) {
    const auto id = std::make_shared<Any>();
    const auto write = [id, on_line = std::move(on_line)](const Reply& reply) {
      return on_line(protocol::reply_line(reply, *id));
    };
    begin(write, from, bytes, [&](Open& open) {
      const Any fields = parse();
      open.id = *id = protocol::request_id(fields);
      const protocol::RequestType& type = protocol::request_type_of(fields);
      open.urgent = type.facts->urgent;
      open.request = protocol::read_request(type, fields);
    });
  }

  void end(const void* from, const Any& id) {
    for (Open& each : open_)
      if (each.from == from && !id.is_null() && each.id == id) each.over = true;
  }

  void refuse(const void* from, const Error& why) {
    std::vector<OnReply> unanswered;  // called last, because a reply may make a new request
    for (Open& each : open_) {
      if (each.from != from || each.over) continue;
      each.over = true;
      if (!each.answered) {
        if (const auto first = std::exchange(each.on_first, nullptr)) first({{}, why, false});
        unanswered.push_back(std::move(each.on_reply));
      }
    }
    for (const OnReply& reply : unanswered) reply({{}, why, false});
  }

  /// With few open requests, advances all of them; with many, as many as the time allows and the rest in
  /// later ticks.
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
  void set_witness(Witness witness) { witness_ = std::move(witness); }

 private:
  struct Open {
    Any id;
    std::optional<Request> request;
    OnReply on_reply;
    std::function<void(const Reply&)> on_first;  // of the witness
    const void* from = nullptr;
    std::size_t bytes = 0;
    AnyPoll poll;
    std::optional<Error> refused;  // reported when it is this request's turn
    bool urgent = false, patient = false, begun = false, answered = false, over = false;
  };
  /// Each tick advances at least kAlways requests, and further ones until kTickTime ns have passed.
  static constexpr std::size_t kAlways = 32;
  static constexpr Nanoseconds kTickTime = 1'000'000;

  template <typename Read>
  void begin(OnReply on_reply, const void* from, std::size_t bytes, Read read) {
    Open open;
    open.on_reply = std::move(on_reply);
    open.from = from;
    open.bytes = bytes;
    guarded(open, [&] {
      read(open);
      open.urgent = open.request->facts().urgent;
      open.patient = open.request->facts().patient;
      if (witness_) open.on_first = witness_(from, *open.request);
      require_room(open);
    });
    if (open.refused) {
      open.request.reset();
      open.bytes = 0;
    }
    // A refusal also waits for its turn; a stop never waits.
    if (open.urgent) overtake(from);
    if (!open.urgent && open_.size() < 2 * bounds::kOpenRequests && must_wait(from)) return keep(std::move(open));
    if (!advance(open)) return keep(std::move(open));
    tell_end(open);
  }

  /// Requests of the same client that were sent before its stop and have not begun must not move what was
  /// stopped; they are refused.
  void overtake(const void* from) {
    for (Open& each : open_)
      if (from && each.from == from && !each.begun && each.request &&
          protocol::role_needed(*each.request) == Role::operate) {
        each.refused = Error(
            "overtaken",
            std::string("'") + each.request->facts().name + "' is refused: a later stop was handled first",
            "send it again if you still want it");
        each.request.reset();
      }
  }

  void keep(Open open) {
    bytes_ += open.bytes;
    open_.push_back(std::move(open));
  }

  void sweep() {
    std::size_t before = 0;
    for (std::size_t i = 0; i < std::min(first_, open_.size()); ++i) before += open_[i].over ? 1 : 0;
    first_ -= before;
    for (Open& open : open_)
      if (open.over) tell_end(open);
    std::erase_if(open_, [&](const Open& open) {
      if (open.over) bytes_ -= open.bytes;
      return open.over;
    });
  }

  /// For the witness of a request that ends without an answer: what it began may have been done.
  static void tell_end(Open& open) {
    if (const auto first = std::exchange(open.on_first, nullptr))
      first({{}, Error("ended", "the client ended it before it was answered"), false});
  }

  /// Limits the open requests of each client, so one client cannot block the others, and those of all clients
  /// together. Urgent requests are always accepted.
  void require_room(const Open& open) const {
    if (open.urgent) return;
    const auto refuse = [](std::size_t most, const char* whose) {
      throw Error("busy", fmt::format("more than {} requests{} are open", most, whose),
                  "wait for answers, or end open requests");
    };
    if (open_.size() >= bounds::kOpenRequests) refuse(bounds::kOpenRequests, "");
    if (bytes_ + open.bytes > bounds::kOpenRequestBytes)
      throw Error("busy",
                  fmt::format("the requests that are open have more than {} bytes", bounds::kOpenRequestBytes),
                  "wait for answers");
    const auto own = [&](const Open& each) { return each.from == open.from; };
    if (open.from && static_cast<std::size_t>(std::count_if(open_.begin(), open_.end(), own)) >=
                         bounds::kOpenRequestsOfOne)
      refuse(bounds::kOpenRequestsOfOne, " of one connection");
  }

  /// True if later requests of the same client must wait for this one.
  static bool waits(const Open& open) {
    return open.from && !open.answered && !open.over && !(open.begun && open.patient);
  }
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

  /// Runs `step`; an error becomes the refusal of the request.
  template <typename Step>
  static void guarded(Open& open, Step step) {
    try {
      step();
    } catch (...) {
      open.refused = error_thrown();
    }
  }

  static bool send(Open& open, const Reply& reply) {
    open.answered = true;
    if (const auto first = std::exchange(open.on_first, nullptr)) first(reply);
    return open.on_reply(reply);
  }

  /// True when the request has ended.
  bool advance(Open& open) {
    AnyProgress progress;
    guarded(open, [&] {
      if (open.refused) return;
      if (!std::exchange(open.begun, true)) {
        open.poll = handlers_.at(&open.request->type()).begin(cell_, *open.request);
        open.request.reset();  // a goal stays open for a long time, and its points need memory
      }
      progress = open.poll();
    });
    if (open.refused) {
      send(open, {{}, std::move(open.refused), false});
      return true;
    }
    if (!progress.answer) return progress.over;
    return !send(open, {std::move(progress.answer), {}, !progress.over}) || progress.over;
  }

  CellInside& cell_;
  Witness witness_;
  std::map<const protocol::RequestType*, Handler> handlers_;
  std::vector<Open> open_;
  std::size_t bytes_ = 0;  // sum of the bytes of all open requests
  std::size_t first_ = 0;  // index at which the next tick continues
};

Requests::Requests(CellInside& cell, const std::vector<Handler>& handlers)
    : work_(std::make_unique<Work>(cell, handlers)) {}
Requests::~Requests() = default;
void Requests::ask(Request request, OnReply on_reply, const void* from, std::size_t bytes) {
  work_->ask(std::move(request), std::move(on_reply), from, bytes);
}
void Requests::set_witness(Witness witness) {
  work_->set_witness(std::move(witness));
}
void Requests::refuse(const void* from, const Error& why) {
  work_->refuse(from, why);
}
void Requests::handle(const std::string& line, OnLine on_line, const void* from) {
  work_->handle(line.size(), std::move(on_line), from, [&] { return protocol::parse_request(line); });
}
void Requests::handle(const Any& fields, std::size_t bytes, OnLine on_line, const void* from) {
  work_->handle(bytes, std::move(on_line), from, [&] { return fields; });
}
void Requests::end(const void* from, const Any& id) {
  work_->end(from, id);
}
void Requests::tick() {
  work_->tick();
}
std::size_t Requests::open() const {
  return work_->open();
}

}  // namespace polyarm::cell
