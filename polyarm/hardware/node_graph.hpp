#pragma once
/// Topics and services of nodes that plugins contain, for the ROS 2 door. A plugin opens a port for each of
/// them; the door connects it to the graph. Payloads are CDR, as on the wire.
///
/// Also included by code of plugins in C++17. The graph belongs to the command: a plugin reaches it through
/// polyarm_node_graph_1, which is null in a program that has none. The number in that name changes with the
/// layout of these types.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace polyarm::hardware {

/// A payload; of a service, with the number of its request.
struct Letter {
  std::uint64_t number = 0;
  std::vector<std::uint8_t> payload;
};

/// Payloads between a plugin and the door. Bounded: when it is full, the oldest is dropped. The memory of the
/// payloads is used again: a queue that has had its largest payload in each place allocates nothing. Any
/// thread.
class LetterQueue {
 public:
  static constexpr std::size_t kMost = 64;              ///< payloads
  static constexpr std::size_t kLargest = 1024 * 1024;  ///< bytes of one

  explicit LetterQueue(std::size_t most) : ring_(std::min(std::max<std::size_t>(most, 1), kMost)) {}

  /// `fill` writes into an empty payload. False if the payload is too large, or if another thread is in the
  /// queue and `waits` is false: then it never waits.
  template <typename Fill>
  bool put(std::uint64_t number, bool waits, Fill&& fill) {
    if (!enter(waits)) return false;
    const Leave leave{busy_};
    if (count_ == ring_.size()) {
      first_ = (first_ + 1) % ring_.size();
      --count_;
    }
    Letter& place = ring_[(first_ + count_) % ring_.size()];
    place.number = number;
    place.payload.clear();
    fill(place.payload);
    if (place.payload.size() > kLargest) return false;
    ++count_;
    return true;
  }
  /// Swaps `out` with the oldest payload. Returns false if no payload waits.
  bool take(Letter& out) {
    enter(true);
    const Leave leave{busy_};
    if (count_ == 0) return false;
    std::swap(out, ring_[first_]);
    first_ = (first_ + 1) % ring_.size();
    --count_;
    return true;
  }

 private:
  struct Leave {
    std::atomic_flag& busy;
    ~Leave() { busy.clear(std::memory_order_release); }
  };
  bool enter(bool waits) {
    while (busy_.test_and_set(std::memory_order_acquire)) {
      if (!waits) return false;
      std::this_thread::yield();
    }
    return true;
  }

  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
  std::vector<Letter> ring_;
  std::size_t first_ = 0, count_ = 0;
};

enum class PortKind : std::uint8_t { publisher, subscription, service, client };

/// What a plugin says of a topic or service when it opens the port.
struct PortFacts {
  PortKind kind = PortKind::publisher;
  std::string node;       ///< full name of its node: "/arm/driver"
  std::string name;       ///< full name: "/arm/driver/state"
  bool absolute = false;  ///< the plugin's name began with "/": a namespace does not change it
  std::string type;       ///< "std_msgs/msg/String"; of a service or client "std_srvs/srv/Trigger"
  bool reliable = true, transient_local = false;
  std::size_t depth = 10;
};

/// One end of a topic or service. It is open as long as the plugin holds it.
class NodePort {
 public:
  explicit NodePort(PortFacts given)
      : facts(std::move(given)), to_graph(facts.depth), from_graph(facts.depth) {}

  const PortFacts facts;
  /// Subscribers of a publisher on the graph; of a client, servers. Written by the door.
  std::atomic<std::uint32_t> peers{0};
  LetterQueue to_graph, from_graph;
};

/// The ports of all plugins in this process. Any thread, but not in a cycle.
class NodeGraph {
 public:
  static constexpr std::size_t kMostPorts = 500;

  virtual ~NodeGraph() = default;
  /// Null if there are kMostPorts.
  virtual std::shared_ptr<NodePort> open(PortFacts facts) = 0;
  /// Those that plugins hold, in the order in which they were opened.
  virtual std::vector<std::shared_ptr<NodePort>> ports() const = 0;
};

NodeGraph& node_graph();

/// While one exists, ports that its thread opens stay off the graph: those of a cell that is only tried must
/// not publish beside the running one.
class OffGraph {
 public:
  OffGraph();
  ~OffGraph();
  OffGraph(const OffGraph&) = delete;
  OffGraph& operator=(const OffGraph&) = delete;
};

}  // namespace polyarm::hardware

/// For plugins: null where the program has no graph.
extern "C" __attribute__((weak)) polyarm::hardware::NodeGraph* polyarm_node_graph_1();
