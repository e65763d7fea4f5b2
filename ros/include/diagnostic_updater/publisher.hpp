#pragma once
#include <memory>

#include "diagnostic_updater/update_functions.hpp"

namespace diagnostic_updater {

class HeaderlessTopicDiagnostic {
 public:
  HeaderlessTopicDiagnostic(const std::string&, Updater&, const FrequencyStatusParam&) {}
  virtual ~HeaderlessTopicDiagnostic() = default;
  virtual void tick() {}
  virtual void clear_window() {}
};
class TopicDiagnostic : public HeaderlessTopicDiagnostic {
 public:
  TopicDiagnostic(const std::string& name, Updater& updater, const FrequencyStatusParam& frequency,
                  const TimeStampStatusParam&)
      : HeaderlessTopicDiagnostic(name, updater, frequency) {}
  using HeaderlessTopicDiagnostic::tick;
  template <typename Stamp>
  void tick(const Stamp&) {}
};
template <typename Publisher>
class DiagnosedPublisher : public TopicDiagnostic {
 public:
  DiagnosedPublisher(std::shared_ptr<Publisher> publisher, Updater& updater, const FrequencyStatusParam& frequency,
                     const TimeStampStatusParam& stamp)
      : TopicDiagnostic(publisher->get_topic_name(), updater, frequency, stamp), publisher_(std::move(publisher)) {}
  template <typename Message>
  void publish(Message&& message) {
    publisher_->publish(std::forward<Message>(message));
  }

 private:
  std::shared_ptr<Publisher> publisher_;
};

}  // namespace diagnostic_updater
