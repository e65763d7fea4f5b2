#pragma once
/// A simulated hand of a robot of Franka: two fingers, and its port. m, N. One thread; nothing here waits.
#include <optional>
#include <string>
#include <vector>

#include "drivers/franka/far_fci.hpp"
#include "drivers/franka/hand.hpp"

namespace polyarm::franka {

/// The fingers. They hold a part when they close on it.
class Fingers {
 public:
  static constexpr double kMost = 0.08;  ///< m, fully open
  /// One millisecond.
  void step();
  /// Nothing: the order is carried out, and take_end() says how it ended.
  std::optional<HandStatus> order(const HandOrder& order, std::uint32_t id, std::uint32_t command);
  struct End {
    std::uint32_t id, command;
    HandStatus status;
  };
  std::optional<End> take_end() { return std::exchange(end_, std::nullopt); }
  HandState state() const;
  void put_part(double width) { part_ = width; }
  double width() const { return width_; }
  bool holds() const { return grasped_; }
  bool fails = false;  ///< orders fail

 private:
  void finish(HandStatus status);
  HandOrder order_;
  std::optional<End> running_, end_;
  std::uint32_t id_ = 1000;
  double width_ = 0.04, part_ = 0;
  bool grasped_ = false, homed_ = true, opening_ = false;
};

class FarHand {
 public:
  FarHand(Fingers& fingers, FarFaults& faults) : fingers_(fingers), faults_(faults) {}
  /// Throws Error("no-port").
  void listen(const std::string& address, int port);
  int port() const { return door_.port(); }
  void descriptors(std::vector<int>& out);
  void serve();
  /// One millisecond of the robot; the hand sends a state in every tenth.
  void cycle();
  void drop() { door_.drop_all(); }
  std::uint32_t newest() const { return newest_; }

 private:
  struct Client {
    Descriptor socket;
    bool gone = false;
    FrameReader reader{kHandHead};
    std::optional<wire::UdpAddress> target;
  };
  bool take(Client& client, const Frame& frame);
  bool connect(Client& client, const Frame& frame);
  bool reply(Client& client, std::uint32_t command, std::uint32_t id, const Data& data);

  Fingers& fingers_;
  FarFaults& faults_;
  wire::Service<Client> door_;
  Descriptor socket_;
  std::uint32_t newest_ = 0;
  int since_ = 0;
};

}  // namespace polyarm::franka
