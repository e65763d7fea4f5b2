#include "links/ros2/port.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "links/ros2/field.hpp"
#include "polyarm/messages/json.hpp"
#include "polyarm/ros2/options.hpp"
#include "polyarm/ros2/wire.hpp"

namespace polyarm::ros2 {

namespace {

using messages::TypeInfo;
using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::LinkValue;
using Role = LinkTag::Role;

constexpr std::size_t kMost = 1000;

/// "std_srvs/Trigger" becomes "std_srvs/srv/Trigger".
std::string service_type(std::string name) {
  const std::size_t slash = name.find('/');
  if (slash != std::string::npos && slash == name.rfind('/')) name.insert(slash, "/srv");
  return name;
}

class Port : public signals::LinkPort {
 public:
  explicit Port(const LinkEntry& entry)
      : entry_{entry},
        options_{participant_options(entry.graph)},
        distribution_{distribution_of(entry.graph)},
        node_{option_of(entry.graph, "node")},
        space_{option_of(entry.graph, "namespace")},
        last_(entry.tags.size()) {
    if (node_.empty()) node_ = "polyarm_" + entry.name;
    std::replace_if(
        node_.begin(), node_.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    while (space_.ends_with('/')) space_.pop_back();
    if (!space_.empty() && space_[0] != '/') space_.insert(0, 1, '/');
    for (std::size_t i = 0; i < entry_.tags.size(); ++i) plan_calls(i);
    for (std::size_t i = 0; i < entry_.tags.size(); ++i) plan(i);
  }

  void open() override {
    wire_.emplace(options_, distribution_);
    losses_ = 0;
    const std::string node = name(node_);
    for (auto& [topic, out] : outgoing_)
      out.publisher = wire_->publisher(node, topic, *out.type, {true, out.latched, out.latched ? 1u : 10u});
    for (auto& [topic, in] : incoming_)
      wire_->subscription(node, topic, *in.type, {!in.best_effort, in.latched, in.latched ? 1u : 10u},
                          [this, &in](std::span<const std::byte> payload) { return take(in, payload); });
    for (auto& [service, call] : calls_) {
      call.asked = false;
      call.client = wire_->client(node, service, call.service, [this, &call](std::span<const std::byte> p) {
        return take_answer(call, p);
      });
    }
  }

  void close() noexcept override { wire_.reset(); }
  bool waits() const override { return true; }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds, Nanoseconds patience,
                LinkReport& news) override {
    send_reports(news);
    const Nanoseconds missing = wire_->participant().missing_for().count();
    if (missing > entry_.timeout)
      throw Error("link-lost", "the process that speaks ROS 2 has ended and is not back yet");
    if (calls_were_lost())
      throw Error("link-lost", "the process that speaks ROS 2 ended during a service call");
    for (const LinkValue& write : writes) put(write);
    if (missing > 0) return std::this_thread::sleep_for(std::chrono::nanoseconds(patience));
    for (auto& [topic, out] : outgoing_)
      if (std::exchange(out.changed, false)) publish(out);
    for (auto& [service, call] : calls_)
      if (call.wanted && !call.asked)
        call.asked = wire_->call(call.client, messages::from_json(*call.request_type, call.request));
    wire_->wait(std::chrono::nanoseconds(patience));
    news_ = &news;
    try {
      wire_->take(kMost);
    } catch (...) {
      news_ = nullptr;
      throw;
    }
    news_ = nullptr;
  }

 private:
  void send_reports(LinkReport& news) {
    for (RemoteReport& each : wire_->take_reports())
      news.notes.push_back(std::move(each.what) + (each.good ? "" : " (" + std::move(each.advice) + ")"));
  }
  /// True if the process that speaks DDS was lost during a service call. The call gets no reply, and it is
  /// unknown whether it was carried out, so the link is lost and calls again when it is back. (Published
  /// values just wait for the process.)
  bool calls_were_lost() {
    const std::uint64_t losses = wire_->participant().statistics().losses;
    if (std::exchange(losses_, losses) == losses) return false;
    return std::any_of(calls_.begin(), calls_.end(),
                       [](const auto& call) { return call.second.wanted && call.second.asked; });
  }

  struct Place {
    std::size_t tag;
    Field field;
  };
  struct Outgoing {
    const TypeInfo* type;
    bool latched = false, changed = false, stamped = false;
    Json message = Json::object();
    Wire::Id publisher = 0;
  };
  struct Incoming {
    const TypeInfo* type;
    bool latched = false, best_effort = false;
    std::vector<Place> places;
  };
  struct Call {
    std::size_t tag;
    std::string service;
    const TypeInfo *request_type, *answer_type;
    Json request = Json::object();
    std::vector<Place> answers;
    bool wanted = false, asked = false;
    Wire::Id client = 0;
  };

  std::string name(const std::string& given) const {
    return given.starts_with('/') ? given : space_ + "/" + given;
  }

  const TypeInfo& type(const LinkTag& tag, const std::string& wanted) const {
    const TypeInfo* found = messages::find_type(wanted, distribution_);
    if (!found)
      throw Error(Problem{"bad-link", tag.where, "'" + tag.name + "': there is no type " + wanted,
                          "docs/ros2.md lists the types"});
    return *found;
  }

  /// Runs `work`; errors get the location of the tag.
  template <class Work>
  auto at(const LinkTag& tag, Work work) const {
    try {
      return work();
    } catch (const Error& e) {
      Problem problem = e.problems().front();
      problem.where = tag.where;
      throw Error(problem);
    }
  }

  void plan_calls(std::size_t index) {
    const LinkTag& tag = entry_.tags[index];
    if (tag.role != Role::call) return;
    const std::string service = service_type(tag.message);
    Call call{index,          service, &type(tag, service + "_Request"), &type(tag, service + "_Response"),
              Json::object(), {}};
    at(tag, [&] { add_constants(tag, *call.request_type, call.request); });
    if (!calls_.emplace(name(tag.topic), std::move(call)).second)
      throw Error(Problem{"bad-link", tag.where, "two tags call " + tag.topic, "one tag calls a service"});
  }

  void plan(std::size_t index) {
    const LinkTag& tag = entry_.tags[index];
    if (tag.role == Role::call) return;
    at(tag, [&] {
      if (tag.role == Role::topic)
        plan_topic(index, type(tag, tag.message));
      else
        plan_part(index);
    });
  }

  void plan_topic(std::size_t index, const TypeInfo& type) {
    const LinkTag& tag = entry_.tags[index];
    Field field(type, tag.field);
    check_fits(tag, field);
    if (tag.direction != Direction::in) {
      Outgoing& out = outgoing_.try_emplace(name(tag.topic), Outgoing{&type}).first->second;
      if (out.type != &type) throw Error("bad-link", "there are two types for " + tag.topic);
      out.latched |= tag.retain;
      out.stamped = !type.fields.empty() && std::string_view(type.fields[0].name) == "header";
      add_constants(tag, type, out.message);
      fields_.emplace(index, field);
    }
    if (tag.direction == Direction::out) return;
    Incoming& in = incoming_.try_emplace(name(tag.topic), Incoming{&type}).first->second;
    if (in.type != &type) throw Error("bad-link", "there are two types for " + tag.topic);
    in.latched |= tag.retain;
    in.best_effort |= tag.best_effort;
    in.places.push_back({index, std::move(field)});
  }

  void plan_part(std::size_t index) {
    const LinkTag& tag = entry_.tags[index];
    const auto call = calls_.find(name(tag.topic));
    if (call == calls_.end())
      throw Error("bad-link", "no tag calls " + tag.topic, "add one: {call: " + tag.topic + ", service: …}");
    const bool request = tag.role == Role::request;
    Field field(request ? *call->second.request_type : *call->second.answer_type, tag.field);
    check_fits(tag, field);
    if (request)
      fields_.emplace(index, std::move(field));
    else
      call->second.answers.push_back({index, std::move(field)});
  }

  void add_constants(const LinkTag& tag, const TypeInfo& type, Json& message) const {
    for (const auto& [path, text] : tag.constants) {
      const Field field(type, path);
      field.set(message, constant_of(field, text));
    }
    messages::from_json(type, message);  // throws if it does not fit the type
  }

  void put(const LinkValue& write) {
    const LinkTag& tag = entry_.tags[write.tag];
    if (tag.role == Role::call) {
      Call& call = calls_.at(name(tag.topic));
      call.wanted = write.value.as_boolean() && *write.value.as_boolean();
      if (!call.wanted) call.asked = false;
      return;
    }
    const Field& field = fields_.at(write.tag);
    const Json value = json_of(tag, field, write.value);
    last_[write.tag] = write.value;
    if (tag.role == Role::request) return field.set(calls_.at(name(tag.topic)).request, value);
    Outgoing& out = outgoing_.at(name(tag.topic));
    field.set(out.message, value);
    out.changed = true;
  }

  void publish(Outgoing& out) {
    if (out.stamped) {
      using std::chrono::nanoseconds;
      const std::int64_t now =
          std::chrono::duration_cast<nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count();
      out.message["header"]["stamp"] = {{"sec", now / 1'000'000'000}, {"nanosec", now % 1'000'000'000}};
    }
    wire_->publish(out.publisher, messages::from_json(*out.type, out.message));
  }

  bool take(const Incoming& in, std::span<const std::byte> payload) {
    Json message;
    if (messages::to_json(*in.type, payload, message) != messages::CdrError::none) return false;
    for (const Place& place : in.places) take(place, message);
    return true;
  }

  /// If the list has no such element, nothing is reported, so the tag becomes stale.
  void take(const Place& place, const Json& message) {
    const Json* given = place.field.find(message);
    if (!given) return;
    std::string why;
    auto value = value_of(entry_.tags[place.tag], *given, why);
    if (!value) return news_->refuse(place.tag, why);
    news_->seen.push_back(place.tag);
    if (last_[place.tag] == value) return;
    last_[place.tag] = value;
    news_->values.push_back({place.tag, std::move(*value)});
  }

  bool take_answer(Call& call, std::span<const std::byte> payload) {
    Json message;
    if (messages::to_json(*call.answer_type, payload, message) != messages::CdrError::none) return false;
    if (!call.asked) return true;  // the call was withdrawn in the meantime
    for (const Place& place : call.answers) {
      last_[place.tag].reset();  // every reply counts as new, even with equal values
      take(place, message);
    }
    call.wanted = call.asked = false;
    news_->seen.push_back(call.tag);
    news_->values.push_back({call.tag, data::Value(false)});
    return true;
  }

  const LinkEntry entry_;
  const ParticipantOptions options_;
  const messages::Distribution distribution_;
  std::string node_, space_;
  std::map<std::string, Outgoing> outgoing_;
  std::map<std::string, Incoming> incoming_;
  std::map<std::string, Call> calls_;             ///< by service
  std::map<std::size_t, Field> fields_;           ///< for outgoing tags
  std::vector<std::optional<data::Value>> last_;  ///< by tag: last known value
  std::optional<Wire> wire_;
  std::uint64_t losses_ = 0;  ///< of the process that speaks DDS
  LinkReport* news_ = nullptr;  ///< during an exchange
};

}  // namespace

std::unique_ptr<signals::LinkPort> make_port(const LinkEntry& entry) {
  return std::make_unique<Port>(entry);
}

}  // namespace polyarm::ros2
