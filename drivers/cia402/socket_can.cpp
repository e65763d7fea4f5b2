#include "drivers/cia402/socket_can.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::cia402 {

namespace {

std::string interfaces_here() {
  std::vector<std::string> names;
  if (struct if_nameindex* const all = ::if_nameindex()) {
    for (const struct if_nameindex* one = all; one->if_index != 0; ++one)
      if (std::strstr(one->if_name, "can")) names.emplace_back(one->if_name);
    ::if_freenameindex(all);
  }
  return names.empty() ? "this machine has no CAN interface: plug the adapter in, and look at `ip link`; an "
                         "adapter with SLCAN has a serial port, such as /dev/ttyACM0"
                       : "the CAN interfaces here are: " + join(names, ", ");
}

[[noreturn]] void refuse_socket(const std::string& bus, int error) {
  const std::string why = std::strerror(error);
  if (error == EACCES || error == EPERM)
    throw Error("port-not-permitted", "the CAN interface " + bus + " may not be opened: " + why,
                "run it as a user that may open CAN sockets");
  if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT)
    throw Error("port-failed", "this kernel has no SocketCAN for " + bus + ": " + why,
                "load it (`sudo modprobe can_raw`), or use an adapter with SLCAN");
  throw Error("port-failed", "the CAN interface " + bus + " cannot be opened: " + why,
              "look at `ip -details link show " + bus + "`");
}

BusState state_of(int error) noexcept {
  switch (error) {
    case ENOBUFS:
    case EAGAIN:
      return BusState::full;
    case ENETDOWN:
      return BusState::off;
    case ENODEV:
    case ENXIO:
    case EPIPE:
    case ECONNRESET:
      return BusState::gone;
    default:
      return BusState::failed;
  }
}

}  // namespace

SocketCanBus::SocketCanBus(const BusOptions& options) {
  const unsigned index = ::if_nametoindex(options.bus.c_str());
  if (index == 0)
    throw Error("no-such-port",
                options.bus.empty() ? "no CAN bus is named" : "there is no CAN interface " + options.bus,
                interfaces_here());
  lock_ =
      hardware::DeviceLock("can:" + options.bus, options.holder.empty() ? "another session" : options.holder);
  socket_ = Descriptor(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket_) refuse_socket(options.bus, errno);
  const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_ACK;
  const can_filter only_standard{0, CAN_EFF_FLAG | CAN_RTR_FLAG};
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (::setsockopt(socket_.number(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
      ::setsockopt(socket_.number(), SOL_CAN_RAW, CAN_RAW_FILTER, &only_standard, sizeof only_standard) !=
          0 ||
      ::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    refuse_socket(options.bus, errno);
  ifreq state{};
  std::strncpy(state.ifr_name, options.bus.c_str(), IFNAMSIZ - 1);
  if (::ioctl(socket_.number(), SIOCGIFFLAGS, &state) == 0 && !(state.ifr_flags & IFF_UP))
    throw Error("port-failed", "the CAN interface " + options.bus + " is down",
                "`sudo ip link set " + options.bus + " up type can bitrate " +
                    std::to_string(options.bit_rate) + " restart-ms 100`");
}

BusState SocketCanBus::send(const CanFrame& frame) noexcept {
  can_frame out{};
  out.can_id = frame.id;
  out.can_dlc = frame.size;
  std::copy_n(frame.data.begin(), frame.data.size(), out.data);
  const ssize_t count = ::send(socket_.number(), &out, sizeof out, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (count == static_cast<ssize_t>(sizeof out)) return off_ ? BusState::off : BusState::ok;
  const BusState state = count < 0 ? state_of(errno) : BusState::failed;
  refused_ += state == BusState::full;
  return state;
}

BusState SocketCanBus::receive(CanFrame& frame, Nanoseconds deadline) noexcept {
  for (;;) {
    can_frame in{};
    const ssize_t count = ::recv(socket_.number(), &in, sizeof in, MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) return BusState::gone;
    if (count < 0 && errno != EAGAIN) return state_of(errno);
    if (count < 0) {
      const Nanoseconds left = std::max<Nanoseconds>(0, deadline - realtime::monotonic_now());
      pollfd waiting{socket_.number(), POLLIN, 0};
      const timespec limit{static_cast<time_t>(left / 1'000'000'000),
                           static_cast<long>(left % 1'000'000'000)};
      if (::ppoll(&waiting, 1, &limit, nullptr) == 0) return BusState::nothing;
      continue;
    }
    if (count == static_cast<ssize_t>(sizeof in) && (in.can_id & CAN_ERR_FLAG)) {
      if (in.can_id & CAN_ERR_ACK) ++refused_;
      if (in.can_id & CAN_ERR_RESTARTED) off_ = false;
      if (in.can_id & CAN_ERR_BUSOFF) {
        off_ = true;
        return BusState::off;
      }
      continue;
    }
    if (count != static_cast<ssize_t>(sizeof in) || (in.can_id & ~CAN_SFF_MASK) || in.can_dlc > 8) {
      ++garbage_;
      continue;
    }
    frame.id = static_cast<std::uint16_t>(in.can_id);
    frame.size = in.can_dlc;
    std::copy_n(in.data, frame.data.size(), frame.data.begin());
    return BusState::ok;
  }
}

}  // namespace polyarm::cia402
