#pragma once
/// From servos out of the box to an arm that can be driven: who is there, ids, ranges, zero; and the way
/// back.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/servo_bus/bus.hpp"

namespace polyarm::servo_bus {

/// Whoever sits before the arm.
class Dialogue {
 public:
  virtual ~Dialogue() = default;
  virtual void say(const std::string& text) = 0;
  /// The answer, without its end of line. `meanwhile` is called again and again until it comes.
  virtual std::string ask(const std::string& question, const std::function<void()>& meanwhile = {}) = 0;
};

struct FoundServo {
  int id = 0, baud = 0, model = 0, firmware = 0;
  double voltage = 0, temperature = 0;
};

/// What the calibration file says of a joint; see setup.hpp.
struct JointCalibration {
  int id = -1;
  std::optional<int> model, zero, min, max, direction;
};
using Calibration = std::map<std::string, JointCalibration>;

struct CommissioningOptions {
  std::vector<std::string> joints;  ///< in the order of their ids, from 1
  std::filesystem::path calibration, backup;
  std::string port;  ///< empty: looked for
  int baud = 0;      ///< 0: all the family has are tried
  int highest_id = 0;
  Nanoseconds answer_timeout = 5'000'000;
};

/// One run of `polyarm setup`. Every step can be done again; what is done already is found in the calibration
/// file and on the bus, and left as it is. Throws Error where it cannot go on.
class Commissioning {
 public:
  Commissioning(const Family& family, std::function<std::unique_ptr<Protocol>()> protocol,
                CommissioningOptions options, Dialogue& dialogue);

  /// Opens the port with servos on it. Moves nothing.
  std::vector<FoundServo> find();
  /// Gives each joint its id, one servo plugged in at a time.
  void assign_ids();
  /// All joints there, of one model and firmware, at a good voltage; says what is not. True when all is well.
  bool check();
  /// Writes the lasting registers of all joints to the backup file; one that is there already is kept, and
  /// the new one gets a number behind its name.
  std::filesystem::path back_up();
  /// Torque off (after a yes), ranges by moving the joints by hand, then zero; writes limits and, where a
  /// range crosses the end of the count, homing into the servos, and the calibration file.
  void calibrate();
  /// Writes a backup back. Returns how many registers were different.
  int restore(const std::filesystem::path& file);

 private:
  struct Range {
    int last = 0, turns = 0, min = 0, max = 0;
    bool known = false;
    int now() const noexcept { return last + turns; }
  };
  void open(const std::string& port, int baud);
  std::vector<FoundServo> scan(int baud);
  std::optional<FoundServo> look_at(int id, int baud);
  std::int32_t get(int id, const Register& reg);
  void set_lasting(int id, const Register& reg, std::int32_t value);
  int id_of(const std::string& joint) const;
  void give_id(const FoundServo& servo, int id);
  void take_torque_off(const std::vector<int>& ids, const std::string& why);
  std::vector<int> ids() const;
  void follow(std::map<std::string, Range>& ranges);
  void move_away_from_the_wrap(const std::string& joint, Range& range);
  void read_calibration();
  void write_calibration() const;

  const Family& family_;
  std::function<std::unique_ptr<Protocol>()> protocol_;
  CommissioningOptions options_;
  Dialogue& dialogue_;
  std::unique_ptr<ServoBus> bus_;
  int baud_ = 0;
  Calibration calibration_;
};

}  // namespace polyarm::servo_bus
