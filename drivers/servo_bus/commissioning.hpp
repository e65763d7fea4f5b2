#pragma once
/// Commissions an arm from new servos: finds them, sets ids, ranges and zero; and restores backups. Blocks;
/// not for the control thread.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/servo_bus/bus.hpp"
#include "drivers/servo_bus/progress.hpp"

namespace polyarm::servo_bus {

/// The operator's console.
class Dialogue {
 public:
  virtual ~Dialogue() = default;
  virtual void say(const std::string& text) = 0;
  /// Returns the answer without its line end. Calls `meanwhile` repeatedly until it arrives.
  virtual std::string ask(const std::string& question, const std::function<void()>& meanwhile = {}) = 0;
};

struct FoundServo {
  int id = 0, baud = 0, model = 0, firmware = 0;
  double voltage = 0, temperature = 0;
};

/// The entry of a joint in the calibration file; see setup.hpp.
struct JointCalibration {
  int id = -1;
  std::optional<int> model, zero, min, max, direction;
};
using Calibration = std::map<std::string, JointCalibration>;

struct CommissioningOptions {
  std::vector<std::string> joints;  ///< in the order of their ids, from 1
  std::filesystem::path calibration, backup;
  std::string port;  ///< empty: searched
  int baud = 0;      ///< 0: all rates of the family are tried
  int highest_id = 0;
  Nanoseconds answer_timeout = 5'000'000;
};

/// One run of `polyarm setup`. Every step can be repeated; completed steps are recognised from the
/// calibration file and the bus, and are kept. Throws Error if it cannot continue.
class Commissioning {
 public:
  Commissioning(const Family& family, std::function<std::unique_ptr<Protocol>()> protocol,
                CommissioningOptions options, Dialogue& dialogue);

  /// Opens the port that has servos. Moves nothing.
  std::vector<FoundServo> find();
  /// Assigns an id to each joint, with one servo plugged in at a time.
  void assign_ids();
  /// Checks that all joints answer, have the same model and firmware and a good voltage; reports faults.
  /// Returns true without faults.
  bool check();
  /// Writes the persistent registers of all joints to the backup file. An existing file is kept; the new one
  /// gets a number in its name.
  std::filesystem::path back_up();
  /// Switches torque off (after confirmation), records ranges while the user moves the joints by hand, then
  /// zero. Writes limits (and homing, if a range crosses the end of the count) into the servos, and the
  /// calibration file. What has been measured is saved meanwhile; a later run continues from it.
  void calibrate();
  /// Restores a backup. Returns the number of registers that differed.
  int restore(const std::filesystem::path& file);

 private:
  struct Range {
    int last = 0, turns = 0, min = 0, max = 0;
    bool known = false;  ///< the joint is being followed
    bool moved = false;  ///< there is a range: of an earlier run, or from before the adapter was gone
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
  using Ranges = std::map<std::string, Range>;
  void follow(Ranges& ranges);
  void lose_adapter(Ranges& ranges);
  bool reopen_if_gone();
  void save(const Ranges& ranges) const;
  int homing_without_wrap(const std::string& joint, Range& range);
  Ranges measure_ranges(const std::optional<Progress>& earlier);
  Progress choose(Ranges ranges);
  void write_registers(const Progress& progress);
  void read_calibration();
  void write_calibration() const;

  const Family& family_;
  std::function<std::unique_ptr<Protocol>()> protocol_;
  CommissioningOptions options_;
  Dialogue& dialogue_;
  std::unique_ptr<ServoBus> bus_;
  int baud_ = 0, looks_ = 0;
  Calibration calibration_;
};

}  // namespace polyarm::servo_bus
