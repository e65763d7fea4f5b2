#include "polyarm/server/client.hpp"

#include <algorithm>

namespace polyarm::server {

bool Client::take(std::string line, double now) {
  allowance_ = std::min(kBurst, allowance_ + (refilled_ > 0 ? (now - refilled_) * kLinesASecond : 0));
  refilled_ = now;
  if (allowance_ < 1) return false;
  allowance_ -= 1;
  {
    const std::lock_guard lock(mutex_);
    in_.push_back(std::move(line));
  }
  if (rope_) rope_->pull();
  return true;
}

bool Client::has_room() const {
  const std::lock_guard lock(mutex_);
  return in_.size() < kMostLines;
}

std::optional<Client::Out> Client::next() {
  const std::lock_guard lock(mutex_);
  if (!out_.empty()) {
    Out out{std::move(out_.front().second), false};
    out_.pop_front();
    out_bytes_ -= out.body->size();
    return out;
  }
  if (!frame_) return std::nullopt;
  return Out{std::exchange(frame_, nullptr), true};
}

std::vector<std::string> Client::lines(std::size_t most) {
  std::vector<std::string> out;
  const std::lock_guard lock(mutex_);
  if (in_.size() >= kMostLines) wake();  // there will be room to read
  while (!in_.empty() && out.size() < most) {
    out.push_back(std::move(in_.front()));
    in_.pop_front();
  }
  return out;
}

bool Client::answer(std::string line) {
  if (gone()) return false;
  {
    const std::lock_guard lock(mutex_);
    out_bytes_ += line.size();
    out_.emplace_back(Kind::answer, std::make_shared<const std::string>(std::move(line)));
    if (out_.size() > kMostOut || out_bytes_ > kMostOutBytes) leave();
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
      out_bytes_ = out_bytes_ - old->second->size() + text->size();
      old->second = std::move(text);
      ++events_left_out_;
    } else if (out_.size() >= kMostOut / 2 || out_bytes_ > kMostOutBytes / 2) {
      ++events_left_out_;
    } else {
      out_bytes_ += text->size();
      out_.emplace_back(kind, std::move(text));
    }
  }
  wake();
}

void Client::put_state(Text frame) {
  if (gone()) return;
  {
    const std::lock_guard lock(mutex_);
    if (frame_) ++frames_left_out_;
    frame_ = std::move(frame);
  }
  wake();
}

}  // namespace polyarm::server
