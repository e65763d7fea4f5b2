/// A link as an edge node of Sparkplug B: births, deaths, data on change, commands.
#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "links/mqtt/connection.hpp"
#include "links/mqtt/port.hpp"
#include "links/mqtt/sparkplug.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::mqtt {

namespace {

using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::LinkValue;

constexpr const char* kRebirth = "Node Control/Rebirth";
constexpr std::size_t kMostNotes = 10;

std::uint64_t now_ms() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

std::uint32_t type_of(const LinkTag& tag) {
  return static_cast<std::uint32_t>(tag.type == LinkTag::Type::boolean  ? MetricType::boolean
                                    : tag.type == LinkTag::Type::number ? MetricType::number
                                                                        : MetricType::text);
}

class SparkplugNode : public signals::LinkPort {
 public:
  explicit SparkplugNode(const LinkEntry& entry)
      : entry_(entry),
        group_(entry_.graph.at("group")),
        node_(entry_.graph.at("node")),
        host_(setting("primary_host")),
        values_(entry_.tags.size()) {
    for (const LinkTag& tag : entry_.tags)
      if (!tag.group.empty()) devices_.insert(tag.group);
    birth_death_ = now_ms() / 1000 % 256;  // another number than that of a process that was killed before
  }
  ~SparkplugNode() override { close(); }

  bool waits() const override { return true; }
  void remember(const std::vector<LinkValue>& known) override {
    for (const LinkValue& each : known) values_[each.tag] = each.value;
  }

  void open() override {
    waiting_.clear();
    waiting_bytes_ = 0;
    born_ = rebirth_asked_ = false;
    host_online_ = host_.empty();
    birth_death_ = (birth_death_ + 1) % 256;
    broker_.open(Will{topic("NDEATH"), death(), 1, false});
    std::vector<std::pair<std::string, int>> topics = {{topic("NCMD"), 1}};
    if (!devices_.empty()) topics.emplace_back(topic("DCMD") + "/+", 1);
    if (!host_.empty()) topics.emplace_back("spBv1.0/STATE/" + host_, 1);
    broker_.subscribe(topics);
    await_host();
    publish_births();
  }

  /// A regular disconnect does not make the broker publish the last will: the node says itself that it goes.
  void close() noexcept override {
    try {
      if (broker_.connected() && born_) broker_.publish(topic("NDEATH"), death(), 1, false), broker_.loop(0);
    } catch (const Error&) {  // the connection is lost already: the broker publishes the will
    }
    born_ = false;
    broker_.close();
  }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds, Nanoseconds patience,
                LinkReport& news) override {
    publish_changes(writes);
    broker_.loop(static_cast<int>(patience / 1'000'000));
    for (int k = 0; k < 100 && !is_much(); ++k) {
      const std::size_t before = waiting_.size();
      broker_.loop(0);
      if (waiting_.size() == before) break;
    }
    commands_ = 0;
    waiting_bytes_ = 0;
    for (const auto& [from, bytes] : std::exchange(waiting_, {})) take(from, bytes, news);
    if (std::exchange(rebirth_asked_, false)) publish_births();
    if (!host_.empty() && !host_online_) {
      close();
      throw Error("link-lost", "the primary host '" + host_ + "' is offline");
    }
  }

 private:
  /// True if this is enough for one round; the rest waits at the broker.
  bool is_much() const {
    return waiting_bytes_ > bounds::kLinkRoundBytes || waiting_.size() > bounds::kLinkRoundValues;
  }
  std::string setting(const std::string& key) const {
    const auto found = entry_.graph.find(key);
    return found == entry_.graph.end() ? "" : found->second;
  }
  std::string topic(const char* type, const std::string& device = {}) const {
    return "spBv1.0/" + group_ + "/" + type + "/" + node_ + (device.empty() ? "" : "/" + device);
  }
  std::string death() const {
    SparkplugPayload out;
    out.time_ms = now_ms();
    out.metrics.push_back({"bdSeq", {}, static_cast<std::uint32_t>(MetricType::uint64), {}, birth_death_});
    return encoded(out);
  }

  /// Sends a payload with the next sequence number.
  void publish(const std::string& to, std::vector<Metric> metrics) {
    SparkplugPayload out;
    out.time_ms = now_ms();
    out.seq = sequence_;
    out.metrics = std::move(metrics);
    sequence_ = (sequence_ + 1) % 256;
    broker_.publish(to, encoded(out), 0, false);
  }

  /// The metric of a tag. In births with name and alias; later with the alias alone.
  Metric metric_of(std::size_t tag, bool birth) const {
    const LinkTag& described = entry_.tags[tag];
    Metric out;
    if (birth) out.name = described.topic;
    out.alias = tag + 1;
    out.type = type_of(described);
    out.time_ms = now_ms();
    if (!values_[tag]) return out;
    const data::Value& value = *values_[tag];
    if (described.type == LinkTag::Type::boolean)
      out.value = value.as_boolean() && *value.as_boolean();
    else if (described.type == LinkTag::Type::number)
      out.value = signals::given_number(described, value);
    else
      out.value = value.text();
    return out;
  }

  void publish_births() {
    sequence_ = 0;
    std::vector<Metric> own;
    own.push_back({"bdSeq", {}, static_cast<std::uint32_t>(MetricType::uint64), now_ms(), birth_death_});
    own.push_back({kRebirth, {}, static_cast<std::uint32_t>(MetricType::boolean), now_ms(), false});
    add_metrics({}, true, own);
    publish(topic("NBIRTH"), std::move(own));
    for (const std::string& device : devices_) {
      std::vector<Metric> metrics;
      add_metrics(device, true, metrics);
      publish(topic("DBIRTH", device), std::move(metrics));
    }
    born_ = true;
  }

  void add_metrics(const std::string& device, bool birth, std::vector<Metric>& out) const {
    for (std::size_t i = 0; i < entry_.tags.size(); ++i)
      if (entry_.tags[i].group == device) out.push_back(metric_of(i, birth));
  }

  /// One message for the node, and one for each device, with what has changed.
  void publish_changes(const std::vector<LinkValue>& writes) {
    std::map<std::string, std::vector<Metric>> changed;
    for (const LinkValue& write : writes) {
      if (values_[write.tag] && *values_[write.tag] == write.value) continue;
      values_[write.tag] = write.value;
      changed[entry_.tags[write.tag].group].push_back(metric_of(write.tag, false));
    }
    for (auto& [device, metrics] : changed)
      publish(device.empty() ? topic("NDATA") : topic("DDATA", device), std::move(metrics));
  }

  void await_host() {
    using Clock = std::chrono::steady_clock;
    for (const auto until = Clock::now() + std::chrono::nanoseconds(entry_.timeout);
         !host_online_ && Clock::now() < until;)
      broker_.loop(20);
    if (!host_online_) throw Error("link-lost", "the primary host '" + host_ + "' is not online");
  }

  void on_message(const mosquitto_message& message) {
    const std::string from = message.topic;
    const auto size = static_cast<std::size_t>(std::max(0, message.payloadlen));
    if (size > kMostMetricText) return;
    const std::string_view bytes(static_cast<const char*>(message.payload), size);
    if (!host_.empty() && from == "spBv1.0/STATE/" + host_) {
      const auto state = host_state(bytes);
      // An older message, of a host that was replaced, changes nothing.
      if (state && (state->time_ms == 0 || state->time_ms >= host_time_))
        host_online_ = state->online, host_time_ = state->time_ms;
    } else if (born_ && !message.retain) {
      // A command is for now: one that the broker has kept, or that came before the birth, would be carried
      // out at each connection.
      waiting_.emplace_back(from, bytes);
      waiting_bytes_ += size;
    }
  }

  void take(const std::string& from, const std::string& bytes, LinkReport& news) {
    std::string device;
    if (const std::string start = topic("DCMD") + "/"; from.starts_with(start))
      device = from.substr(start.size());
    else if (from != topic("NCMD"))
      return;
    const auto payload = decoded(bytes);
    if (!payload) return note(news, "a command that is no payload of Sparkplug is ignored: " + from);
    for (const Metric& metric : payload->metrics) {
      const bool* const flag = std::get_if<bool>(&metric.value);
      if (device.empty() && metric.name == kRebirth) {
        rebirth_asked_ = rebirth_asked_ || (flag && *flag);
        continue;
      }
      if (++commands_ > bounds::kLinkRoundValues)
        return note(news, "more commands than one round takes are ignored");
      command(device, metric, news);
    }
  }

  /// Only tags whose direction is `in` or `both` take commands.
  void command(const std::string& device, const Metric& metric, LinkReport& news) {
    for (std::size_t i = 0; i < entry_.tags.size(); ++i) {
      const LinkTag& tag = entry_.tags[i];
      const bool named = metric.name.empty() ? metric.alias == i + 1 : metric.name == tag.topic;
      if (!named || tag.group != device) continue;
      if (tag.direction == Direction::out)
        return news.refuse(i, "no command may set it: its direction is out");
      std::string why;
      auto value = value_for(tag, metric, why);
      if (!value) return news.refuse(i, why);
      values_[i] = *value;
      news.seen.push_back(i);
      news.values.push_back({i, std::move(*value)});
      // The host sees the value that is taken.
      return publish(device.empty() ? topic("NDATA") : topic("DDATA", device), {metric_of(i, false)});
    }
    note(news, "a command for a metric that is not here is ignored: '" + metric.name.substr(0, 60) + "'");
  }

  static std::optional<data::Value> value_for(const LinkTag& tag, const Metric& metric, std::string& why) {
    const double* const number = std::get_if<double>(&metric.value);
    const std::uint64_t* const whole = std::get_if<std::uint64_t>(&metric.value);
    if (tag.type == LinkTag::Type::number && (number || whole))
      return signals::taken_number(tag, number ? *number : static_cast<double>(*whole), why);
    if (const bool* flag = std::get_if<bool>(&metric.value); tag.type == LinkTag::Type::boolean && flag)
      return data::Value(*flag);
    if (const std::string* text = std::get_if<std::string>(&metric.value);
        tag.type == LinkTag::Type::text && text)
      return data::Value(*text);
    why = "the metric has another type, or no value";
    return std::nullopt;
  }

  static void note(LinkReport& news, std::string text) {
    if (news.notes.size() < kMostNotes) news.notes.push_back(std::move(text));
  }

  const LinkEntry entry_;
  const std::string group_, node_, host_;
  std::set<std::string> devices_;
  Connection broker_{entry_, [this](const mosquitto_message& message) { on_message(message); }};
  std::vector<std::optional<data::Value>> values_;            ///< by tag
  std::vector<std::pair<std::string, std::string>> waiting_;  ///< commands, by topic
  std::uint64_t birth_death_ = 0, sequence_ = 0, host_time_ = 0;
  std::size_t waiting_bytes_ = 0, commands_ = 0;  ///< of this round
  bool born_ = false, host_online_ = false, rebirth_asked_ = false;
};

}  // namespace

std::unique_ptr<signals::LinkPort> make_sparkplug(const LinkEntry& entry) {
  return std::make_unique<SparkplugNode>(entry);
}

}  // namespace polyarm::mqtt
