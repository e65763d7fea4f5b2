#include "polyarm/hardware/node_graph.hpp"

#include <mutex>

#include "polyarm/base/bounds.hpp"

namespace polyarm::hardware {

// Plugins include the header without the command's other headers.
static_assert(LetterQueue::kMost == bounds::kNodePayloads);
static_assert(LetterQueue::kLargest == bounds::kNodePayloadBytes);
static_assert(NodeGraph::kMostPorts == bounds::kNodePorts);

namespace {
thread_local int off_graph = 0;

class Graph final : public NodeGraph {
 public:
  std::shared_ptr<NodePort> open(PortFacts facts) override {
    if (off_graph > 0) return std::make_shared<NodePort>(std::move(facts));
    const std::lock_guard lock(mutex_);
    std::erase_if(ports_, [](const auto& each) { return each.expired(); });
    if (ports_.size() >= kMostPorts) return nullptr;
    auto out = std::make_shared<NodePort>(std::move(facts));
    ports_.push_back(out);
    return out;
  }
  std::vector<std::shared_ptr<NodePort>> ports() const override {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<NodePort>> out;
    for (const auto& each : ports_)
      if (auto port = each.lock()) out.push_back(std::move(port));
    return out;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::weak_ptr<NodePort>> ports_;
};
}  // namespace

OffGraph::OffGraph() {
  ++off_graph;
}
OffGraph::~OffGraph() {
  --off_graph;
}

NodeGraph& node_graph() {
  static Graph graph;
  return graph;
}

}  // namespace polyarm::hardware

polyarm::hardware::NodeGraph* polyarm_node_graph_1() {
  return &polyarm::hardware::node_graph();
}
