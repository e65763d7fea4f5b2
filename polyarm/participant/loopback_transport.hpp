#pragma once
/// UDP on 127.0.0.1 that reaches every participant on this machine. Fast DDS's own transport, when restricted
/// to loopback, drops participants that announce an address of another interface of this machine. ROS 2's
/// middleware on Fast DDS announces such addresses in every discovery range, although it also listens on
/// loopback. Here such an address is replaced by 127.0.0.1. Only participant.cpp includes this.
#include "polyarm/participant/plain_keys_transport.hpp"

namespace polyarm::ros2 {

class LoopbackTransport : public PlainKeysTransport {
 public:
  using PlainKeysTransport::PlainKeysTransport;

  bool transform_remote_locator(const rtps::Locator_t& remote, rtps::Locator_t& result) const override {
    return transport::ChainingTransport::transform_remote_locator(reached(remote), result);
  }
  bool is_locator_allowed(const rtps::Locator_t& locator) const override {
    return transport::ChainingTransport::is_locator_allowed(reached(locator));
  }
#ifdef POLYARM_FAST_DDS_3
  bool transform_remote_locator(const rtps::Locator_t& remote, rtps::Locator_t& result, bool theirs,
                                bool ours) const override {
    return transport::ChainingTransport::transform_remote_locator(reached(remote), result, theirs, ours);
  }
#endif

 private:
  /// The locator under which a locator of this machine is reached.
  rtps::Locator_t reached(const rtps::Locator_t& locator) const {
    rtps::Locator_t out = locator;
    if (low_level_transport_->IsLocatorSupported(locator) && !rtps::IPLocator::isMulticast(locator) &&
        low_level_transport_->is_local_locator(locator))
      rtps::IPLocator::setIPv4(out, 127, 0, 0, 1);
    return out;
  }
};

}  // namespace polyarm::ros2
