#pragma once
/// The driver's end of a TCP port of a robot of Franka, or of its hand. send() may be called by another
/// thread than receive() and next(); open() and close() by no two threads at a time.
#include <atomic>
#include <string>

#include "drivers/franka/fci.hpp"
#include "drivers/franka/words.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::franka {

class Port {
 public:
  struct Failure {
    Cause cause = Cause::none;
    std::string text;
  };
  /// `head`: bytes before the data of a frame, 12 or 10.
  Port(std::string host, int port, std::size_t head = kFciHead)
      : host_(std::move(host)), port_(port), head_(head), reader_(head) {}
  /// Waits for the connection. False: see failure().
  bool open(Nanoseconds timeout);
  void close() { socket_ = Descriptor(); }
  bool is_open() const { return static_cast<bool>(socket_); }
  int descriptor() const { return socket_.number(); }
  /// The address of this machine that the robot can answer to.
  std::string own_address() const { return wire::local_address(socket_.number()); }
  std::string peer_address() const { return wire::peer_address(socket_.number()); }

  /// The id of the request; nothing if the connection is of no use. Never waits.
  std::optional<std::uint32_t> send(std::uint32_t command, const Data& data);
  /// Takes what has come; never waits. False: the connection is of no use, and failure() says why.
  bool receive();
  std::optional<Frame> next();
  /// The reply to a request; waits for it, and drops other replies. Nothing: see failure().
  std::optional<Frame> ask(std::uint32_t command, const Data& data, Nanoseconds timeout);
  const Failure& failure() const { return failure_; }

 private:
  bool fail(Cause cause, const std::string& text = {});
  std::string host_;
  int port_;
  std::size_t head_;
  Descriptor socket_;
  FrameReader reader_;
  std::atomic<std::uint32_t> id_{0};
  Failure failure_;
};

/// Connects to the robot, with the version that it speaks. `udp_port`: of this machine, as bound by `bind`,
/// which gets the address of this machine and returns the port, or 0 if it could not. False: `why` has the
/// cause.
struct Refusal {
  Cause cause = Cause::none;
  int detail = 0;
  std::string text;
};
template <class Bind>
bool connect_robot(Port& port, int& version, Nanoseconds timeout, Bind bind, Refusal& why) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (!port.open(timeout)) return why = {port.failure().cause, 0, port.failure().text}, false;
    const int udp_port = bind(port.own_address());
    if (udp_port == 0) return false;
    Data data;
    for (const int value : {version, udp_port}) {
      data.push_back(static_cast<std::uint8_t>(value));
      data.push_back(static_cast<std::uint8_t>(value >> 8));
    }
    const auto reply = port.ask(0, data, timeout);
    if (!reply) {
      const Cause cause = port.failure().cause;
      return why = {cause == Cause::closed ? Cause::no_session : cause, 0, port.failure().text}, false;
    }
    if (reply->data.size() != 3 || reply->data[0] > 1) return why = {Cause::bad_data, 0, {}}, false;
    const int spoken = reply->data[1] | reply->data[2] << 8;
    if (reply->data[0] == 0) return true;
    port.close();
    if (spoken < kOldestVersion || spoken > kNewestVersion || spoken == version)
      return why = {Cause::other_version, spoken, {}}, false;
    version = spoken;
  }
  return why = {Cause::other_version, version, {}}, false;
}

}  // namespace polyarm::franka
