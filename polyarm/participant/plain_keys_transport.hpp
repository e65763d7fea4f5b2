#pragma once
/// UDP transport that passes received messages through with_plain_keys() before Fast DDS gets them. Only
/// participant.cpp includes this.
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "polyarm/participant/disposal_keys.hpp"
#include "polyarm/participant/fast_dds.hpp"
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

class PlainKeysTransport : public transport::ChainingTransport {
 public:
  explicit PlainKeysTransport(const transport::ChainingTransportDescriptor& descriptor)
      : transport::ChainingTransport(descriptor) {}

  transport::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }
#ifdef POLYARM_FAST_DDS_3
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
  /// Called on the thread that reads a socket.
  void receive(transport::TransportReceiverInterface* next, const rtps::octet* data, std::uint32_t size,
               const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
    thread_local std::vector<std::uint8_t> plain;
    if (with_plain_keys({data, size}, plain))
      next->OnDataReceived(plain.data(), static_cast<std::uint32_t>(plain.size()), local, remote);
    else
      next->OnDataReceived(data, size, local, remote);
  }
};

/// Descriptor that makes a transport of class T above `udp`.
template <class T>
struct AboveUdp : transport::ChainingTransportDescriptor {
  explicit AboveUdp(std::shared_ptr<transport::TransportDescriptorInterface> udp)
      : transport::ChainingTransportDescriptor(std::move(udp)) {}
  transport::TransportInterface* create_transport() const override { return new T(*this); }
};

}  // namespace polyarm::ros2
