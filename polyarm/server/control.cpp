#include "polyarm/server/control.hpp"

#include <algorithm>

namespace polyarm::server {

using What = ControlReport::What;

double Control::left(double now) const {
  return asker_ ? std::max(0.0, until_ - now) : 0;
}

Control::Taken Control::take(std::uint64_t client, bool at_once, double now) {
  if (holder_ == client) return Taken::yes;
  if (holder_ == 0) {
    holder_ = client;
    return Taken::yes;
  }
  if (at_once) {
    if (asker_ && asker_ != client) news_.push_back({asker_, What::refused, client});
    asker_ = client;
    hand_to_asker(What::taken);
    return Taken::yes;
  }
  if (asker_ == client) return Taken::asked;
  if (asker_) return Taken::others;
  asker_ = client;
  until_ = now + kTimeout;
  news_.push_back({holder_, What::asked, client});
  return Taken::asked;
}

bool Control::release(std::uint64_t client) {
  if (!holds(client)) return false;
  if (asker_) {
    hand_to_asker(What::lost);
    return true;
  }
  holder_ = 0;
  news_.push_back({0, What::free, client});
  return true;
}

bool Control::answer(std::uint64_t client, bool give) {
  if (!holds(client) || !asker_) return false;
  if (give) {
    hand_to_asker(What::lost);
  } else {
    news_.push_back({asker_, What::refused, client});
    asker_ = 0;
  }
  return true;
}

void Control::gone(std::uint64_t client) {
  if (client == asker_) asker_ = 0;
  if (!holds(client)) return;
  if (asker_)
    hand_to_asker(What::lost);
  else
    holder_ = 0;
}

void Control::tick(double now) {
  if (asker_ && now >= until_) hand_to_asker(What::lost);
}

void Control::hand_to_asker(What to_old) {
  news_.push_back({holder_, to_old, asker_});
  news_.push_back({asker_, What::given, holder_});
  holder_ = std::exchange(asker_, 0);
}

}  // namespace polyarm::server
