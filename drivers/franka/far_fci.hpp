#pragma once
/// The ports of a simulated robot of Franka: requests, states and commands. One thread; nothing here waits.
#include <string>
#include <vector>

#include "drivers/franka/machine.hpp"
#include "drivers/wire/far_packets.hpp"
#include "drivers/wire/service.hpp"

namespace polyarm::franka {

/// What goes wrong on purpose; those of packets are of states and commands.
struct FarFaults : wire::PacketFaults {
  bool not_a_number = false;  ///< the next state has a position that is NaN
  bool mute = false;          ///< no replies
  bool bad_reply = false;     ///< the next reply is no frame
  bool busy = false;          ///< it has another client
  bool power_off = false;     ///< nothing answers
  int other_version = 0;      ///< the version that it speaks; 0: its own
  int drop = 0;               ///< commands that get lost
  bool hand_silent = false, hand_mute = false, hand_fails = false;
  int hand_version = 0;
};

class FarFci {
 public:
  FarFci(Machine& machine, FarFaults& faults) : machine_(machine), faults_(faults) {}
  /// Throws Error("no-port").
  void listen(const std::string& address, int port);
  int port() const { return door_.port(); }
  void descriptors(std::vector<int>& out);
  void serve();
  /// One millisecond: the machine moves, and a state goes out.
  void cycle();
  void drop() { door_.drop_all(); }
  /// The last state of a motion has no answer yet, also before the client's first one.
  bool unanswered() const { return unanswered_ > 0 && machine_.moves(); }
  /// The same, and there is somebody who answers.
  bool waits() const { return answers_ && unanswered(); }
  /// States that the driver may take for the robot's, and the id of the newest one.
  std::uint64_t states() const { return sent_; }
  std::uint64_t newest() const { return newest_; }
  std::uint64_t answers() const { return taken_; }
  std::uint64_t requests() const { return requests_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    FrameReader reader;
    bool connected = false;
  };
  bool take(Client& client, const Frame& frame);
  bool connect(Client& client, const Frame& frame);
  bool reply(Client& client, const Frame& frame, Data data);
  void take_commands();
  void report_end();
  void send_state();
  Client* session();
  int spoken() const { return faults_.other_version > 0 ? faults_.other_version : machine_.version(); }

  Machine& machine_;
  FarFaults& faults_;
  wire::Service<Client> door_;
  wire::FarSocket socket_;
  bool has_session_ = false;
  bool answers_ = false;
  int unanswered_ = 0;
  std::uint64_t sent_ = 0, newest_ = 0, taken_ = 0, requests_ = 0;
};

}  // namespace polyarm::franka
