#pragma once
/// Questions about a cell that the I/O thread takes and the cell thread answers; and the port for Prometheus.
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/server/port.hpp"

namespace polyarm::server {

/// Any thread.
class Scrapes {
 public:
  static constexpr std::size_t kMostWaiting = bounds::kScrapes;
  enum class Kind { prometheus, summary };
  using Reply = std::function<void(HttpReply)>;

  /// Replies 503 at once if too many wait.
  void ask(Kind kind, Reply reply);
  /// Takes what waits. Cell thread.
  std::vector<std::pair<Kind, Reply>> take();
  bool any() const;
  /// The cell thread answers no more: what waits, and what comes, is refused.
  void close();

 private:
  mutable std::mutex mutex_;
  std::vector<std::pair<Kind, Reply>> waiting_;
  bool closed_ = false;
};

/// Serves GET /metrics and nothing else, without a token.
class MetricsSite : public Site {
 public:
  explicit MetricsSite(Scrapes& scrapes) : scrapes_(scrapes) {}
  bool is_open(const std::string& method, const std::string& path) const override;
  std::size_t most_body(const std::string&, const std::string&) const override { return 0; }
  void handle(HttpRequest request, std::function<void(HttpReply)> reply) override;
  std::shared_ptr<Client> welcome(Client::Side) override { return nullptr; }

 private:
  Scrapes& scrapes_;
};

}  // namespace polyarm::server
