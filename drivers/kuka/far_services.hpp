#pragma once
/// The services of a simulated KUKA controller: RSI and EthernetKRL. One thread; nothing here waits.
#include <string>
#include <vector>

#include "drivers/kuka/far_moves.hpp"
#include "drivers/kuka/machine.hpp"
#include "drivers/wire/far_packets.hpp"
#include "drivers/wire/service.hpp"

namespace polyarm::kuka {

/// What goes wrong on purpose; those of packets are RSI's.
struct FarFaults : wire::PacketFaults {
  bool mute = false;           ///< EthernetKRL gives no answers
  bool nonsense = false;       ///< what it sends is no XML
  bool busy = false;           ///< it has another client
  bool other_program = false;  ///< it is another version
  bool power_off = false;      ///< nothing answers
};

/// RSI: the controller sends to a computer, which answers.
class FarRsi {
 public:
  FarRsi(Machine& machine, FarFaults& faults, std::string sen_type)
      : machine_(machine), faults_(faults), sen_type_(std::move(sen_type)) {}
  /// Throws Error("no-port").
  void open(const std::string& address) { socket_.open(address); }
  /// Throws Error("bad-value").
  void send_to(const std::string& address, int port) { socket_.send_to(address, port, "RSI", 59152); }
  int descriptor() const { return socket_.descriptor(); }
  void serve();
  /// One cycle: the machine moves, and a packet goes out.
  void cycle();
  /// The newest packet has no answer yet.
  bool unanswered() const { return unanswered_ > 0 && !renewed_; }
  /// The same, if there is somebody who answers: without a driver the clock goes on.
  bool waits() const { return answers_ && unanswered(); }
  /// Packets that the driver may take for the controller's.
  std::uint64_t packets() const { return packets_; }
  std::uint64_t sent_clock() const { return sent_clock_; }
  std::uint64_t answers() const { return taken_; }

 private:
  void send();

  Machine& machine_;
  FarFaults& faults_;
  std::string sen_type_;
  wire::FarSocket socket_;
  std::uint64_t packets_ = 0, taken_ = 0, sent_clock_ = 0, session_ = 0;
  bool answers_ = false;
  bool renewed_ = false;  ///< the clock began anew: no driver answers any more
  int unanswered_ = 0;    ///< packets of this session
};

/// Our KRL programs behind EthernetKRL. They take one client; without one, a session of moves ends.
class FarEki {
 public:
  FarEki(Machine& machine, FarMoves& moves, FarFaults& faults)
      : machine_(machine), moves_(moves), faults_(faults) {}
  void listen(const std::string& address, int port) { door_.listen(address, port); }
  int port() const { return door_.port(); }
  void serve();
  void descriptors(std::vector<int>& out);
  void drop() {
    door_.drop_all();
    moves_.end();
  }
  std::uint64_t requests() const { return requests_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    EkiReader reader;
  };
  bool is_first(const Client& client);
  bool take(Client& client, const std::string& text);
  EkiResult carry_out(const EkiRequest& request);

  Machine& machine_;
  FarMoves& moves_;
  FarFaults& faults_;
  wire::Service<Client> door_;
  std::uint64_t requests_ = 0;
};

}  // namespace polyarm::kuka
