#pragma once
/// A client of ROS 2 as its middleware on Fast DDS makes one: topics, services and actions by their names,
/// messages as JSON. It shares the room `messages` with what it looks at; tests/ros2/wire_test.cpp has a far
/// side that shares nothing.
#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm/messages/json.hpp"
#include "polyarm/participant/participant.hpp"

namespace polyarm::ros2::test {

using nlohmann::json;

template <class Until>
bool wait(Until until, int seconds = 30) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (!until()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

class Client {
 public:
  explicit Client(std::uint32_t domain)
      : participant_{std::make_shared<Participant>([&] {
          ParticipantOptions made;
          made.domain = domain;
          return made;
        }())} {}

  /// Keeps what comes on a topic. A fixture may keep it beyond the client: it holds the participant.
  class Listener {
   public:
    Listener(std::shared_ptr<Participant> participant, const std::string& topic, const std::string& type, Qos qos)
        : participant_{std::move(participant)}, type_{*messages::find_type(type)} {
      id_ = participant_->add_reader("rt" + topic, type_.dds_name, qos, "", [this](const Sample& sample) {
        json message;
        if (messages::to_json(type_, sample.payload, message) != messages::CdrError::none) return;
        const std::lock_guard lock(mutex_);
        messages_.push_back(std::move(message));
      });
    }
    ~Listener() { participant_->remove(id_); }
    std::size_t count() const {
      const std::lock_guard lock(mutex_);
      return messages_.size();
    }
    json latest() const {
      const std::lock_guard lock(mutex_);
      return messages_.empty() ? json() : messages_.back();
    }
    /// What has come after the first `count`.
    std::vector<json> since(std::size_t count) const {
      const std::lock_guard lock(mutex_);
      return {messages_.begin() + static_cast<std::ptrdiff_t>(count), messages_.end()};
    }
    bool heard() const { return count() > 0; }
    bool matched() const { return !participant_->matched(id_).empty(); }

   private:
    std::shared_ptr<Participant> participant_;
    const messages::TypeInfo& type_;
    Participant::Id id_;
    mutable std::mutex mutex_;
    std::deque<json> messages_;
  };
  std::unique_ptr<Listener> listen(const std::string& topic, const std::string& type, Qos qos = {}) {
    return std::make_unique<Listener>(participant_, topic, type, qos);
  }

  class Publisher {
   public:
    Publisher(std::shared_ptr<Participant> participant, const std::string& topic, const std::string& type)
        : participant_{std::move(participant)}, type_{*messages::find_type(type)} {
      id_ = participant_->add_writer("rt" + topic, type_.dds_name, {}, "");
    }
    bool matched() const { return !participant_->matched(id_).empty(); }
    void publish(const json& message) { participant_->write(id_, messages::from_json(type_, message)); }

   private:
    std::shared_ptr<Participant> participant_;
    const messages::TypeInfo& type_;
    Participant::Id id_;
  };
  std::unique_ptr<Publisher> publish(const std::string& topic, const std::string& type) {
    return std::make_unique<Publisher>(participant_, topic, type);
  }

  /// Waits until the service is there, asks, and waits for the answer.
  json call(const std::string& service, const std::string& type, const json& request = json::object()) {
    Caller& caller = caller_of(service, type);
    if (!wait([&] { return caller.ready(); })) throw std::runtime_error(service + " is not there");
    return caller.call(request);
  }

  Participant& participant() { return *participant_; }

 private:
  class Caller {
   public:
    Caller(Participant& participant, const std::string& service, const std::string& type)
        : participant_{participant},
          request_{*messages::find_type(type + "_Request")},
          response_{*messages::find_type(type + "_Response")} {
      replies_ = participant.add_reader("rr" + service + "Reply", response_.dds_name, {}, "",
                                        [this](const Sample& s) {
                                          const std::lock_guard lock(mutex_);
                                          if (s.related == me_)
                                            reply_.emplace(s.payload.begin(), s.payload.end());
                                        });
      {
        const std::lock_guard lock(mutex_);
        me_ = participant.guid(replies_);
      }
      requests_ = participant.add_writer("rq" + service + "Request", request_.dds_name, {}, "");
    }
    bool ready() const {
      return !participant_.matched(replies_).empty() && !participant_.matched(requests_).empty();
    }
    json call(const json& request) {
      {
        const std::lock_guard lock(mutex_);
        reply_.reset();
      }
      participant_.write(requests_, messages::from_json(request_, request), Related{me_, 0});
      json out;
      const bool answered = wait([&] {
        const std::lock_guard lock(mutex_);
        return reply_.has_value() && messages::to_json(response_, *reply_, out) == messages::CdrError::none;
      });
      if (!answered) throw std::runtime_error(std::string("no answer to ") + request_.name);
      return out;
    }

   private:
    Participant& participant_;
    const messages::TypeInfo &request_, &response_;
    Participant::Id replies_ = 0, requests_ = 0;
    std::mutex mutex_;
    Guid me_ = kNoGuid;
    std::optional<std::vector<std::byte>> reply_;
  };
  Caller& caller_of(const std::string& service, const std::string& type) {
    auto& caller = callers_[service];
    if (!caller) caller = std::make_unique<Caller>(*participant_, service, type);
    return *caller;
  }

  std::shared_ptr<Participant> participant_;  ///< with those that listen and publish
  std::map<std::string, std::unique_ptr<Caller>> callers_;
};

}  // namespace polyarm::ros2::test
