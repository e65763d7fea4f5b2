#pragma once
/// The services of a simulated ABB controller: EGM and Robot Web Services. One thread; nothing here waits.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/abb/machine.hpp"
#include "drivers/wire/far_packets.hpp"
#include "drivers/wire/http.hpp"
#include "drivers/wire/tls.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::abb {

/// What goes wrong on purpose; those of packets are EGM's.
struct FarFaults : wire::PacketFaults {
  bool restarted = false;   ///< the sequence of the packets begins anew
  bool old = false;         ///< EGM before version 1.1
  bool seven = false;       ///< the robot has seven joints
  bool egm_error = false;   ///< EGM reports an error
  bool slow = false;        ///< packets come in twice their time
  bool mute = false;        ///< Robot Web Services give no answers
  bool busy = false;        ///< they have too many sessions
  bool login = false;       ///< they refuse the user
  bool forbidden = false;   ///< the user may change nothing
  bool mastership = false;  ///< somebody else holds it
  bool nonsense = false;    ///< what they send is no HTTP
  bool no_option = false;   ///< Externally Guided Motion is not installed
  bool refuse_start = false, refuse_motors = false;
  bool power_off = false;  ///< nothing answers
};

/// EGM: the controller sends to a computer, which answers.
class FarEgm {
 public:
  FarEgm(Machine& machine, FarFaults& faults) : machine_(machine), faults_(faults) {}
  /// Throws Error("no-port").
  void open(const std::string& address) { socket_.open(address); }
  /// Throws Error("bad-value").
  void send_to(const std::string& address, int port) { socket_.send_to(address, port, "EGM", 6510); }
  int descriptor() const { return socket_.descriptor(); }
  int port() const { return wire::local_port(socket_.descriptor()); }
  void serve();
  /// One cycle: the machine moves, and a packet goes out.
  void cycle();
  /// The newest packet has no answer yet.
  bool unanswered() const { return unanswered_ > 0 && !renewed_; }
  /// The same, if there is somebody who answers: without a driver the clock goes on.
  bool waits() const { return answers_ && unanswered(); }
  /// Packets that the driver may take for the controller's.
  std::uint64_t packets() const { return packets_; }
  std::uint32_t sent_sequence() const { return sent_sequence_; }
  std::uint64_t messages() const { return messages_; }
  bool sends() const { return sending_; }

 private:
  EgmRobot packet() const;
  void send();
  void begin_session();

  Machine& machine_;
  FarFaults& faults_;
  wire::FarSocket socket_;
  std::uint32_t sequence_ = 0, sent_sequence_ = 0;
  std::uint64_t packets_ = 0, messages_ = 0;
  bool sending_ = false, answers_ = false;
  int unanswered_ = 0;        ///< packets of this session; an answer does not say which one it answers
  bool renewed_ = false;      ///< the sequence began anew: no driver answers any more
  std::uint64_t starts_ = 0;  ///< of the program, at the begin of this session
  int last_packets_ = 0;      ///< that still go out after EGM ended
  double began_ = 0;
};

/// Robot Web Services, version 1 or 2.
class FarRws {
 public:
  FarRws(Machine& machine, FarFaults& faults, int version);
  void listen(const std::string& address, int port);
  int port() const { return port_; }
  void serve();
  void descriptors(std::vector<int>& out) const;
  void drop();
  std::uint64_t requests() const { return requests_; }
  void set_user(const std::string& user, const std::string& password);
  /// The time for the TLS handshake with the first request, and for each further request from its first byte
  /// on. A connection that takes longer is closed.
  void set_request_time(Nanoseconds time) { request_time_ = time; }

 private:
  struct Client {
    wire::Channel channel;
    wire::HttpReader reader{wire::HttpReader::Kind::request};
    bool gone = false, known = false;
    Nanoseconds begun = 0;  ///< of the connection, then of the request that is not complete; 0: it is idle
  };
  struct Answer {
    int status = 200;
    std::string body;
  };
  void read(Client& client);
  void close_unfinished();
  void take(Client& client, const wire::HttpMessage& request);
  bool allowed(const wire::HttpMessage& request) const;
  Answer answer(const wire::HttpMessage& request);
  Answer get(const std::string& path);
  Answer post(const std::string& path, const std::string& query, const std::string& form);
  Answer change_panel(const std::string& path, const std::string& form);
  Answer change_program(const std::string& path, const std::string& form);
  Answer put(const std::string& path, const std::string& text);
  static Answer page(const std::string& kind, const std::string& title, const std::string& spans);
  static Answer refusal(int status, const std::string& text);
  Answer done(const std::string& wrong) const;
  Answer event_log() const;
  std::string challenge() const;
  bool second() const { return version_ == 2; }

  Machine& machine_;
  FarFaults& faults_;
  int version_, port_ = 0;
  std::optional<wire::TlsContext> context_;
  Descriptor listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::string user_ = "Default User", password_ = "robotics", nonce_;
  Nanoseconds request_time_ = static_cast<Nanoseconds>(bounds::kHead_ms) * 1'000'000;
  std::uint64_t requests_ = 0;
  bool master_ = false;
};

}  // namespace polyarm::abb
