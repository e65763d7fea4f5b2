#include "polyarm/server/scrapes.hpp"

namespace polyarm::server {

void Scrapes::ask(Kind kind, Reply reply) {
  {
    const std::lock_guard lock(mutex_);
    if (!closed_ && waiting_.size() < kMostWaiting) {
      waiting_.emplace_back(kind, std::move(reply));
      return;
    }
  }
  reply(plain(503, "too many questions at once: try again"));
}

std::vector<std::pair<Scrapes::Kind, Scrapes::Reply>> Scrapes::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

bool Scrapes::any() const {
  const std::lock_guard lock(mutex_);
  return !waiting_.empty();
}

void Scrapes::close() {
  std::vector<std::pair<Kind, Reply>> left;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    left = std::exchange(waiting_, {});
  }
  for (auto& [kind, reply] : left) reply(plain(503, "the command ends"));
}

bool MetricsSite::is_open(const std::string& method, const std::string&) const {
  return method == "GET" || method == "HEAD";
}

void MetricsSite::handle(HttpRequest request, std::function<void(HttpReply)> reply) {
  if (request.path == "/metrics") return scrapes_.ask(Scrapes::Kind::prometheus, std::move(reply));
  reply(plain(404, "only /metrics is served here"));
}

}  // namespace polyarm::server
