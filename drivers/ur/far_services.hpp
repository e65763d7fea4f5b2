#pragma once
/// The services of a simulated controller of Universal Robots: RTDE, dashboard, primary and secondary
/// interface, and the program that a driver sends. One thread; nothing here waits.
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "drivers/ur/far_moves.hpp"
#include "drivers/ur/machine.hpp"
#include "drivers/ur/rtde.hpp"
#include "drivers/ur/script.hpp"
#include "drivers/wire/service.hpp"

namespace polyarm::ur {

/// What goes wrong on purpose.
struct FarFaults {
  bool wrong_version = false;  ///< RTDE accepts no protocol version
  bool second_client = false;  ///< somebody else holds all inputs
  bool silent = false;         ///< RTDE sends nothing
  bool garbage = false;        ///< the next RTDE package is not valid
  int duplicate = 0;           ///< packages that are sent twice
  int reorder = 0;             ///< packages that are sent after the next one
  int late = 0;                ///< packages that are kept back, then sent together
  bool unreachable = false;    ///< programs cannot connect to the driver
  bool deaf = false;           ///< the program does not read
  std::string exception;       ///< the next program ends with this error
};

using wire::Service;

/// RTDE, protocol 1 and 2.
class FarRtde {
 public:
  FarRtde(Machine& machine, FarFaults& faults, double rate)
      : machine_(machine), faults_(faults), rate_(rate) {}
  struct Client {
    Descriptor socket;
    bool gone = false;
    FrameStream frames;
    int protocol = 1;
    std::vector<std::string> outputs;
    Recipe output_recipe;
    int divisor = 1;
    bool started = false;
    struct Inputs {
      std::vector<std::string> names;
      Recipe recipe;
    };
    std::vector<Inputs> inputs;
    std::vector<std::vector<std::uint8_t>> kept;  ///< packages that a fault keeps back
  };
  Service<Client>& service() { return service_; }
  const Service<Client>& service() const { return service_; }
  void serve();
  /// Sends what is due in this cycle.
  void send(std::uint64_t cycle);
  /// The machine's time in the newest package that went out, s.
  double sent_time() const { return sent_time_; }

 private:
  bool take(Client& client, PackageType type, Bytes payload);
  void set_up_outputs(Client& client, Bytes payload);
  void set_up_inputs(Client& client, Bytes payload);
  void take_inputs(Client& client, Bytes payload);
  void send(Client& client);
  bool is_taken(const Client& client, const std::string& input);
  std::vector<std::uint8_t> package_of(Client& client);

  Machine& machine_;
  FarFaults& faults_;
  double rate_;
  Service<Client> service_;
  double sent_time_ = 0;
};

/// The program that runs on the controller.
class FarProgram {
 public:
  FarProgram(Machine& machine, FarFaults& faults) : machine_(machine), faults_(faults), moves_(machine) {}
  /// Starts the program in place of the present one. Returns the text of a runtime exception, or "".
  std::string start(const std::string& text);
  void stop();
  void pause(bool on);
  void play();  ///< again, the last one
  bool runs() const { return kind_ != Kind::none; }
  /// Reads commands. True if the program came to its end.
  bool serve();
  /// One step: timeouts, motion.
  void step(double dt);
  std::int32_t last_sequence() const { return sequence_; }
  std::uint64_t messages() const { return messages_; }
  void descriptors(std::vector<int>& out) const;
  void close_stream();
  const std::string& name() const { return name_; }

 private:
  enum class Kind : std::uint8_t { none, own, moves, external_control, other };
  struct Opened {
    std::string host, name;
    int port = 0;
  };
  static std::vector<Opened> sockets_of(const std::string& text);
  bool open(const std::string& name);
  void take(Bytes message);
  void take_external(Bytes message);
  void take_own(Bytes message);
  void take_moves(Bytes message);
  bool is_ours() const { return kind_ == Kind::own || kind_ == Kind::moves; }
  std::size_t message_bytes() const;
  void finish(ScriptState state);

  Machine& machine_;
  FarFaults& faults_;
  FarMoves moves_;
  Kind kind_ = Kind::none;
  std::string text_, name_;
  std::vector<Opened> opened_;
  Descriptor stream_, trajectory_, commands_;
  std::vector<std::uint8_t> buffer_;
  double quiet_ = 0, wait_limit_ = 0;  // s; 0: without end
  double lookahead_ = 0.03;
  std::int32_t sequence_ = 0;
  std::uint64_t messages_ = 0;
  bool ended_ = false;
};

/// Primary (with messages) and secondary interface.
class FarPrimary {
 public:
  FarPrimary(Machine& machine, FarProgram& program) : machine_(machine), program_(program) {}
  struct Client {
    Descriptor socket;
    bool gone = false;
    std::string text;
  };
  Service<Client>& primary() { return primary_; }
  const Service<Client>& primary() const { return primary_; }
  Service<Client>& secondary() { return secondary_; }
  const Service<Client>& secondary() const { return secondary_; }
  void serve();
  void send_state();
  void program_ended();
  void send(const std::vector<std::uint8_t>& package);

 private:
  bool take(Client& client, Bytes bytes);
  bool take_script(Client& client, const std::string& text);
  std::vector<std::uint8_t> state() const;
  std::uint64_t time() const { return static_cast<std::uint64_t>(machine_.time() * 1e6); }

  Machine& machine_;
  FarProgram& program_;
  Service<Client> primary_, secondary_;
};

/// The dashboard server.
class FarDashboard {
 public:
  FarDashboard(Machine& machine, FarProgram& program, FarPrimary& primary)
      : machine_(machine), program_(program), primary_(primary) {}
  struct Client {
    Descriptor socket;
    bool gone = false;
    std::string text;
  };
  Service<Client>& service() { return service_; }
  const Service<Client>& service() const { return service_; }
  void serve();
  /// The answer to one line.
  std::string answer(const std::string& line);

 private:
  Machine& machine_;
  FarProgram& program_;
  FarPrimary& primary_;
  Service<Client> service_;
};

}  // namespace polyarm::ur
