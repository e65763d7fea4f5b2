#pragma once
/// One process for each device: a port, a bus address, a network peer.
#include <string>

namespace polyarm::hardware {

/// Holds a device for this process until it is destroyed. The kernel lets go of it when the process ends, in
/// whatever way. Any thread.
class DeviceLock {
 public:
  DeviceLock() = default;
  /// `device`: a path, or any name for what cannot be shared ("/dev/i2c-1:0x60", "192.168.1.10:30004"). Paths
  /// are followed through links first, so that two names of one port meet. `holder`: what the refusal of
  /// another process shall call this one ("the cell lab, component wheels"). Throws Error("device-in-use")
  /// naming the holder, Error("lock-failed") where no lock file can be made.
  DeviceLock(const std::string& device, const std::string& holder);
  ~DeviceLock();
  DeviceLock(DeviceLock&& other) noexcept;
  DeviceLock& operator=(DeviceLock&& other) noexcept;
  DeviceLock(const DeviceLock&) = delete;
  DeviceLock& operator=(const DeviceLock&) = delete;

  bool held() const noexcept { return file_ >= 0; }
  /// For a process that goes on holding the device when this one is gone: it holds it as long as it has the
  /// descriptor. -1: nothing is held.
  int descriptor() const noexcept { return file_; }

  /// Who holds the device, in its own words; empty: nobody, as far as this user can see. Touches nothing.
  static std::string holder(const std::string& device);

 private:
  int file_ = -1;
};

}  // namespace polyarm::hardware
