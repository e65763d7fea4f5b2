#pragma once
/// The driver's end of the command port of a controller of UFACTORY. One thread at a time.
#include <string>

#include "drivers/wire/tcp.hpp"
#include "drivers/xarm/ux.hpp"
#include "drivers/xarm/words.hpp"

namespace polyarm::xarm {

class UxPort {
 public:
  UxPort(std::string host, int port) : host_(std::move(host)), port_(port) {}
  /// Waits for the connection. False: see failure().
  bool open(Nanoseconds timeout);
  void close() { socket_ = Descriptor(); }
  bool is_open() const { return static_cast<bool>(socket_); }
  int descriptor() const { return socket_.number(); }

  /// Nothing waits. False: the connection is of no use, and failure() says why.
  bool send(Register reg, const std::vector<std::uint8_t>& data);
  bool receive();
  /// The answer to what was sent last; answers to something else are dropped. Nothing: none is there, or
  /// failure() says why.
  std::optional<UxReply> next();

  /// The answer to a request; waits for it. Nothing: see failure().
  std::optional<UxReply> ask(Register reg, const std::vector<std::uint8_t>& data, Nanoseconds timeout);

  struct Failure {
    Cause cause = Cause::none;
    std::string text;
  };
  const Failure& failure() const { return failure_; }

 private:
  bool fail(Cause cause, const std::string& text = {});
  std::string host_;
  int port_;
  Descriptor socket_;
  UxReader reader_;
  std::uint16_t transaction_ = 0;
  Register asked_{};
  Failure failure_;
};

}  // namespace polyarm::xarm
