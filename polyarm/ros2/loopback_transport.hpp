#pragma once
/// UDP on 127.0.0.1 alone that reaches every participant of this machine. Fast DDS's own drops who announces
/// an address of another interface of this machine (as ROS 2's middleware on Fast DDS does, in each range)
/// once it is told to use loopback alone, though the other side hears on loopback, too: here such an address
/// is 127.0.0.1. Only participant.cpp includes this.
#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "polyarm/ros2/fast_dds.hpp"
#ifdef POLYARM_FAST_DDS_3
#include <fastdds/rtps/transport/ChainingTransport.hpp>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.hpp>
#include <fastdds/rtps/transport/SenderResource.hpp>
#else
#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#endif

namespace polyarm::ros2 {

namespace transport = eprosima::fastdds::rtps;

class LoopbackTransport : public transport::ChainingTransport {
 public:
  explicit LoopbackTransport(const transport::ChainingTransportDescriptor& descriptor)
      : transport::ChainingTransport(descriptor) {}

  transport::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

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
  bool send(rtps::SenderResource* below, const std::vector<transport::NetworkBuffer>& buffers,
            std::uint32_t size, rtps::LocatorsIterator* begin, rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& until) override {
    return below->send(buffers, size, begin, end, until);
  }
#else
  bool send(rtps::SenderResource* below, const rtps::octet* data, std::uint32_t size,
            rtps::LocatorsIterator* begin, rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& until) override {
    return below->send(data, size, begin, end, until);
  }
#endif
  void receive(transport::TransportReceiverInterface* next, const rtps::octet* data, std::uint32_t size,
               const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
    next->OnDataReceived(data, size, local, remote);
  }

 private:
  /// Where a locator of this machine is reached.
  rtps::Locator_t reached(const rtps::Locator_t& locator) const {
    rtps::Locator_t out = locator;
    if (low_level_transport_->IsLocatorSupported(locator) && !rtps::IPLocator::isMulticast(locator) &&
        low_level_transport_->is_local_locator(locator))
      rtps::IPLocator::setIPv4(out, 127, 0, 0, 1);
    return out;
  }
};

struct LoopbackDescriptor : transport::ChainingTransportDescriptor {
  explicit LoopbackDescriptor(std::shared_ptr<transport::TransportDescriptorInterface> udp)
      : transport::ChainingTransportDescriptor(std::move(udp)) {}
  transport::TransportInterface* create_transport() const override { return new LoopbackTransport(*this); }
};

}  // namespace polyarm::ros2
