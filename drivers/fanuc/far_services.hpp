#pragma once
/// The services of a simulated FANUC controller: Stream Motion and the Remote Motion Interface. One thread;
/// nothing here waits.
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/fanuc/far_motion.hpp"
#include "drivers/fanuc/machine.hpp"
#include "drivers/fanuc/rmi.hpp"
#include "drivers/wire/far_packets.hpp"
#include "drivers/wire/service.hpp"

namespace polyarm::fanuc {

/// What goes wrong on purpose; those of packets are Stream Motion's.
struct FarFaults : wire::PacketFaults {
  bool mute = false;       ///< the Remote Motion Interface gives no answers
  bool busy = false;       ///< another program uses the Remote Motion Interface
  bool old = false;        ///< Stream Motion has version 1
  bool no_stream = false;  ///< the streaming program is not installed
  bool refuse = false;     ///< remote motion is refused
  bool stuck = false;      ///< the streaming program does not become ready
};

/// Stream Motion.
class FarStream {
 public:
  FarStream(Machine& machine, FarFaults& faults, double period);
  /// Throws Error("no-port").
  void listen(const std::string& address, int port);
  int port() const { return wire::local_port(socket_.number()); }
  int descriptor() const { return socket_.number(); }
  void serve();
  /// One cycle: the commands, the machine, the packet.
  void cycle();
  /// The streaming program was called, or ended.
  void program(bool on);
  bool program_runs() const { return program_; }
  bool ready() const;
  /// The newest packet has no answer yet.
  bool unanswered() const { return started_ && answered_ < sent_; }
  std::uint32_t sent_sequence() const { return sent_; }
  std::uint64_t commands() const { return commands_; }
  std::uint32_t version() const { return faults_.old ? 1 : version_; }
  void set_version(std::uint32_t version) { version_ = version; }

 private:
  void take(Bytes packet, const wire::UdpAddress& from);
  void take_start(std::uint32_t version);
  void take_command(const Command& command);
  void take_io_setup(const IoSetup& setup);
  void follow();
  bool judge(const Six& next);
  void send();
  Status status() const;
  void apply_outputs(const IoArea& io);

  Machine& machine_;
  FarFaults& faults_;
  double period_;
  Descriptor socket_;
  std::optional<wire::UdpAddress> client_;
  std::uint32_t version_ = 3, negotiated_ = 3, sequence_ = 0, sent_ = 0, answered_ = 0;
  bool started_ = false, program_ = false, client_answers_ = false, moving_ = false;
  IoSetup io_{};
  std::deque<Command> buffer_;  ///< with motion, not yet carried out
  std::uint32_t due_ = 0, start_move_ = 5;
  int missed_ = 0;
  std::uint64_t commands_ = 0;
  Six velocity_{}, acceleration_{};
  std::array<LimitTable, 18> tables_;
  double speed_ = 0;  ///< mm/s, of the face plate
  std::array<double, 6> pose_{};
  wire::PacketQueue packets_;
};

/// The Remote Motion Interface.
class FarRmi {
 public:
  FarRmi(Machine& machine, FarFaults& faults, FarStream& stream);
  void listen(const std::string& address, int port, int session_port);
  int port() const { return door_.port(); }
  void serve();
  /// One cycle of the queue of instructions.
  void cycle(double dt);
  void descriptors(std::vector<int>& out);
  bool connected() const { return session_ != nullptr; }
  void drop();       ///< both doors, as at a restart
  void terminate();  ///< as after a long silence
  void abort();      ///< all programs, as at the teach pendant
  void pause(bool on);
  std::uint64_t done() const { return motion_.done(); }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    RmiLines lines;
  };
  using Handler = void (FarRmi::*)(const RmiMessage&);
  struct Entry {
    const char* name;
    Handler handler;
  };
  static const Entry kCommands[], kInstructions[];

  void take_greeting(Client& client, const RmiMessage& message);
  void take(const RmiMessage& message);
  void take_instruction(const RmiMessage& message);
  void answer(RmiLine line);
  void answer(const RmiMessage& message, int error);
  RmiLine reply(const RmiMessage& message, int error = 0) const;
  void open_session();
  void report_fault();

  // commands
  void initialize(const RmiMessage&);
  void abort_command(const RmiMessage&);
  void pause_command(const RmiMessage&);
  void resume(const RmiMessage&);
  void reset(const RmiMessage&);
  void read_error(const RmiMessage&);
  void get_status(const RmiMessage&);
  void get_more_status(const RmiMessage&);
  void set_override(const RmiMessage&);
  void set_frames(const RmiMessage&);
  void get_frames(const RmiMessage&);
  void read_frame(const RmiMessage&);
  void write_frame(const RmiMessage&);
  void read_joints(const RmiMessage&);
  void read_pose(const RmiMessage&);
  void read_speed(const RmiMessage&);
  void read_port(const RmiMessage&);
  void write_port(const RmiMessage&);
  void read_register(const RmiMessage&);
  void write_register(const RmiMessage&);
  void accept(const RmiMessage&);

  Machine& machine_;
  FarFaults& faults_;
  FarStream& stream_;
  FarMotion motion_;
  wire::Service<Client> door_;
  std::string address_;
  int session_port_ = 16002;
  Descriptor listener_;
  std::unique_ptr<Client> session_;
  bool initialized_ = false;
  std::string reported_;
};

}  // namespace polyarm::fanuc
