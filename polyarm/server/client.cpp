#include "polyarm/server/client.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/protocol/session.hpp"
#include "polyarm/protocol/wire.hpp"

namespace polyarm::server {

namespace {

using Json = nlohmann::json;

/// Cost of a queued line in addition to its text.
constexpr std::size_t kLineCost = 64;
/// A client with fewer unread bytes than this is not disconnected when all clients together have too many.
constexpr std::size_t kModest = 512 << 10;
static_assert((bounds::kPageClients + bounds::kControlSeats) * kModest <= bounds::kAllOutBytes);

}  // namespace

/// Parses short lines only: this thread reads for all clients.
std::optional<Client::Urgent> Client::urgent_of(const std::string& line) {
  if (line.size() > bounds::kUrgentBytes) return std::nullopt;
  const auto named = [&](const char* name) { return line.find(name) != std::string::npos; };
  if (!named("control.stop") && !named("control.hold") && !named("jog.beat") && !named("jog.end"))
    return std::nullopt;
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return std::nullopt;
  const Json name = request.value("request", Json());
  if (name == "control.stop" || name == "control.hold") return Urgent{true, false};
  if (name == "jog.end") return Urgent{false, !request.contains("jog")};
  return name == "jog.beat" ? std::optional(Urgent{}) : std::nullopt;
}

std::string Client::shown_name(const std::string& given) const {
  if (!login) return given;
  return given.empty() ? login->user : login->user + " (" + given + ")";
}

users::Actor Client::actor(const std::string& shown) const {
  users::Actor out;
  out.role = protocol::name(role);
  out.name = login ? login->user : "link to " + out.role;
  out.from = from;
  out.door = "pendant";
  if (shown != out.name && shown != from) out.client = shown;
  return out;
}

void Client::require_role(protocol::Role needed, const std::string& request) const {
  if (role >= needed) return;
  throw Error("no-role",
              "'" + request + "' is refused: " + (login ? login->user : "this link") + " has the role " +
                  protocol::name(role) + ", and that needs the role " + protocol::name(needed),
              login ? "log in as a user who may do it" : "open a link that allows it");
}

void Client::Line::require_not_overtaken(const protocol::RequestType& type,
                                         const protocol::Any& arguments) const {
  const bool jogs = type.facts == &protocol::JogBegin::kFacts || type.facts == &protocol::JogGoto::kFacts;
  if (!before_stop && !(before_end && jogs)) return;
  if (protocol::role_needed(type, arguments) != protocol::Role::operate) return;
  throw Error("overtaken",
              std::string("'") + type.facts->name + "' is refused: your later stop was handled first",
              "send it again if you still want it");
}

Client::~Client() {
  all_->in -= in_bytes_;
  all_->out -= out_bytes_;
}

bool Client::take(std::string line, double now) {
  const double passed = refilled_ > 0 ? now - refilled_ : 0;
  allowance_ = std::min(kBurst, allowance_ + passed * kLinesASecond);
  bytes_allowed_ = std::min<double>(bounds::kClientBurstBytes,
                                    bytes_allowed_ + passed * bounds::kClientBytesASecond);
  refilled_ = now;
  const auto urgent = urgent_of(line);
  // A stop is accepted even when the rate limit is used up.
  if (urgent && urgent->stops) allowance_ = std::max(allowance_, 1.0);
  bytes_allowed_ -= static_cast<double>(line.size());
  if (allowance_ < 1 || bytes_allowed_ < 0) return false;
  allowance_ -= 1;
  if (urgent) {
    if (!take_urgent(std::move(line), *urgent)) return false;
  } else {
    const std::size_t bytes = line.size() + kLineCost;
    std::unique_lock lock(mutex_);
    if (in_bytes_ + bytes > kMostIn || all_->in + bytes > bounds::kAllInBytes) {
      lock.unlock();
      refuse(line);
      return true;
    }
    in_bytes_ += bytes;
    all_->in += bytes;
    in_.push_back(std::move(line));
  }
  if (rope_) rope_->pull();
  return true;
}

/// An equal line that is already queued is not queued again. When the queue is full, the oldest heartbeat is
/// dropped.
bool Client::take_urgent(std::string line, Urgent urgent) {
  const std::lock_guard lock(mutex_);
  if (urgent.stops) before_stop_ = in_.size();
  if (urgent.ends) before_end_ = in_.size();
  if (std::find(urgent_.begin(), urgent_.end(), line) != urgent_.end()) return true;
  if (urgent_.size() >= kMostUrgent) {
    const auto beat = std::find_if(urgent_.begin(), urgent_.end(), [](const std::string& each) {
      return each.find("jog.beat") != std::string::npos;
    });
    if (beat == urgent_.end()) return false;
    urgent_.erase(beat);
  }
  urgent_.push_back(std::move(line));
  return true;
}

void Client::refuse(const std::string& line) {
  Json answer{{"ok", false},
              {"error",
               {{"code", "busy"},
                {"what", "too many requests of this connection wait"},
                {"advice", "wait for answers"},
                {"where", ""}}}};
  if (line.size() <= bounds::kUrgentBytes) {
    const Json request = Json::parse(line, nullptr, false);
    if (request.is_object() && request.contains("id") && request["id"].is_primitive())
      answer["id"] = request["id"];
  }
  this->answer(answer.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::optional<Client::Out> Client::next() {
  const std::lock_guard lock(mutex_);
  if (!out_.empty()) {
    Out out{std::move(out_.front().second), false};
    out_.pop_front();
    drop_out(out.body->size());
    return out;
  }
  if (!frame_) return std::nullopt;
  return Out{std::exchange(frame_, nullptr), true};
}

std::vector<std::string> Client::urgent() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> out(std::make_move_iterator(urgent_.begin()),
                               std::make_move_iterator(urgent_.end()));
  urgent_.clear();
  return out;
}

std::optional<Client::Line> Client::line() {
  const std::lock_guard lock(mutex_);
  if (in_.empty()) return std::nullopt;
  Line out{std::move(in_.front()), before_stop_ > 0, before_end_ > 0};
  in_.pop_front();
  if (before_stop_ > 0) --before_stop_;
  if (before_end_ > 0) --before_end_;
  in_bytes_ -= out.text.size() + kLineCost;
  all_->in -= out.text.size() + kLineCost;
  return out;
}

bool Client::too_much(std::size_t share) const {
  return out_.size() > kMostOut / share || out_bytes_ > kMostOutBytes / share ||
         (out_bytes_ > kModest / share && all_->out > bounds::kAllOutBytes);
}

bool Client::answer(std::string line) {
  if (gone()) return false;
  {
    const std::lock_guard lock(mutex_);
    add_out(line.size());
    out_.emplace_back(Kind::answer, std::make_shared<const std::string>(std::move(line)));
    if (too_much(1)) leave();
  }
  wake();
  return !gone();
}

bool Client::waits(Kind kind) const {
  const std::lock_guard lock(mutex_);
  return std::any_of(out_.begin(), out_.end(), [&](const auto& each) { return each.first == kind; });
}

void Client::put(Kind kind, Text text) {
  if (gone()) return;
  {
    const std::lock_guard lock(mutex_);
    const auto old = kind == Kind::log ? out_.end()
                                       : std::find_if(out_.begin(), out_.end(),
                                                      [&](const auto& each) { return each.first == kind; });
    if (old != out_.end()) {
      drop_out(old->second->size());
      add_out(text->size());
      old->second = std::move(text);
      ++omitted_events_;
    } else if (too_much(2)) {
      ++omitted_events_;
    } else {
      add_out(text->size());
      out_.emplace_back(kind, std::move(text));
    }
  }
  wake();
}

void Client::put_state(Text frame) {
  if (gone()) return;
  {
    const std::lock_guard lock(mutex_);
    if (frame_) ++omitted_frames_;
    frame_ = std::move(frame);
  }
  wake();
}

}  // namespace polyarm::server
