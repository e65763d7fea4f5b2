#include "polyarm/server/viewers.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/recording/foxglove_server.hpp"
#include "polyarm/recording/live_view.hpp"

namespace polyarm::server {

namespace {

class ViewerStream : public Stream {
 public:
  explicit ViewerStream(std::shared_ptr<recording::FoxgloveClient> client) : client_(std::move(client)) {}

  const char* take(std::string message, bool binary, double now) override {
    const double passed = seen_ > 0 ? now - seen_ : 0;
    allowance_ = std::min(kBurst, allowance_ + passed * kASecond);
    bytes_ = std::min<double>(bounds::kViewerBurstBytes, bytes_ + passed * bounds::kViewerBytesASecond);
    bytes_ -= static_cast<double>(message.size());
    seen_ = now;
    // This thread also reads everybody's stops, so long or frequent messages are refused before they are
    // parsed.
    if (message.size() > bounds::kViewerRequestBytes) return "the message is too long";
    if (--allowance_ < 0 || bytes_ < 0) return "too many messages a second";
    if (binary)
      client_->take_binary(message);
    else
      client_->take_text(message);
    return nullptr;
  }
  std::optional<Client::Out> next() override {
    auto out = client_->next();
    if (!out) return std::nullopt;
    return Client::Out{std::move(out->body), out->binary};
  }
  bool gone() const override { return gone_.load(std::memory_order_acquire); }
  void leave() override { gone_.store(true, std::memory_order_release); }

 private:
  static constexpr double kASecond = 200, kBurst = bounds::kViewerMessages;
  std::shared_ptr<recording::FoxgloveClient> client_;
  double allowance_ = kBurst, bytes_ = bounds::kViewerBurstBytes, seen_ = 0;
  std::atomic<bool> gone_{false};
};

std::string session_name() {
  return std::to_string(std::chrono::system_clock::now().time_since_epoch().count());
}

}  // namespace

class Viewers::Work {
 public:
  explicit Work(const std::string& version) : server({"polyarm", version, session_name(), false, 16}) {}
  recording::FoxgloveServer server;
  std::unique_ptr<recording::LiveView> view;
};

Viewers::Viewers(const std::string& version) : work_(std::make_unique<Work>(version)) {}
Viewers::~Viewers() = default;

std::shared_ptr<Stream> Viewers::welcome() {
  auto client = work_->server.connect();
  return client ? std::make_shared<ViewerStream>(std::move(client)) : nullptr;
}

void Viewers::set_wake(std::function<void()> wake) {
  work_->server.set_wake(std::move(wake));
}

void Viewers::attach(cell::CellView& cell) {
  work_->view.reset();
  work_->view = std::make_unique<recording::LiveView>(cell, work_->server);
}

void Viewers::detach() {
  work_->view.reset();
}

bool Viewers::serve() {
  return work_->view && work_->view->serve();
}

}  // namespace polyarm::server
