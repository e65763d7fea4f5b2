#pragma once
/// The services of a simulated controller of Yaskawa: MotoROS and the High-Speed Ethernet Server. One thread;
/// nothing here waits.
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/service.hpp"
#include "drivers/wire/udp.hpp"
#include "drivers/yaskawa/far_job.hpp"
#include "drivers/yaskawa/machine.hpp"

namespace polyarm::yaskawa {

/// What goes wrong on purpose.
struct FarFaults {
  bool silent = false;          ///< no states
  bool mute = false;            ///< no answers about motion
  bool nonsense = false;        ///< the next state is no message
  bool bad_answer = false;      ///< the next answer about motion is no message
  bool other_group = false;     ///< states are of another group
  bool io_mute = false;         ///< no answers about signals
  bool locked_outputs = false;  ///< outputs cannot be written
  bool hses_mute = false;       ///< the Ethernet server gives no answers
  bool hses_nonsense = false;   ///< what it sends is no datagram of it
  bool hses_refuse = false;     ///< it refuses each request
  bool hses_twice = false;      ///< it answers twice
  bool no_job = false;          ///< the job POLYARM is not loaded
  bool locked_places = false;   ///< position variables cannot be written
  int hses_lost = 0;            ///< answers that get lost
  bool power_off = false;       ///< nothing answers
  bool other_client = false;    ///< another client moves the robot: new ones are closed
  int late = 0;                 ///< states that are kept back, then sent together
};

class FarMoto {
 public:
  FarMoto(Machine& machine, FarFaults& faults, ByteOrder order, int state_cycles)
      : machine_(machine), faults_(faults), order_(order), state_cycles_(state_cycles) {}
  /// Throws Error("no-port").
  void listen(const std::string& address, int motion, int state, int io);
  int motion_port() const { return motion_.port(); }
  int state_port() const { return state_.port(); }
  int io_port() const { return io_.port(); }
  void descriptors(std::vector<int>& out);
  void serve();
  /// One interpolation cycle: the machine moves, and states go out when they are due.
  void cycle();
  void drop_motion() { motion_.drop_all(); }
  void drop_states() { state_.drop_all(); }
  void drop_io() { io_.drop_all(); }
  void drop_all();

  /// States that went out, and the number of the newest one for its client.
  std::uint64_t states() const { return states_; }
  std::uint64_t newest() const { return newest_; }
  std::uint64_t requests() const { return requests_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    MotoReader reader;
    std::uint64_t states = 0;
    std::string kept;                   ///< states that a fault keeps back
    std::optional<MotoControl> starts;  ///< waits for the job
    double waited = 0;                  ///< s
  };
  void admit(Client& client);
  bool take_motion(Client& client, Bytes bytes);
  bool take_io(Client& client, Bytes bytes);
  bool answer_motion(Client& client, const Message& message);
  bool answer_io(Client& client, const Message& message);
  bool control(Client& client, const MotoControl& what);
  void finish_starts();
  bool reply(Client& client, const MotoReply& reply);
  bool send(Client& client, std::span<const std::uint8_t> bytes);
  void send_state(Client& client);

  Machine& machine_;
  FarFaults& faults_;
  ByteOrder order_;
  int state_cycles_, since_state_ = 0;
  wire::Service<Client> motion_, state_, io_;
  std::uint64_t states_ = 0, newest_ = 0, requests_ = 0;
};

/// The Ethernet server, without files.
class FarHses {
 public:
  FarHses(Machine& machine, Variables& variables, FarFaults& faults)
      : machine_(machine), variables_(variables), faults_(faults) {}
  /// Throws Error("no-port").
  void open(const std::string& address, int port);
  int port() const { return port_; }
  int descriptor() const { return socket_.number(); }
  void serve();
  std::uint64_t requests() const { return requests_; }

 private:
  HsesReply answer(const HsesRequest& request);
  HsesReply read(const HsesRequest& request, HsesReply reply);
  HsesReply act(const HsesRequest& request, HsesReply reply);
  HsesReply io(const HsesRequest& request, HsesReply reply);
  HsesReply many_io(const HsesRequest& request, HsesReply reply);
  HsesReply variable(const HsesRequest& request, HsesReply reply);
  HsesReply many_doubles(const HsesRequest& request, HsesReply reply);
  HsesReply network(const HsesRequest& request, HsesReply reply);
  HsesReply position(const HsesRequest& request, HsesReply reply);
  HsesReply system(const HsesRequest& request, HsesReply reply);

  Machine& machine_;
  Variables& variables_;
  FarFaults& faults_;
  Descriptor socket_;
  int port_ = 0;
  std::uint64_t requests_ = 0;
};

}  // namespace polyarm::yaskawa
