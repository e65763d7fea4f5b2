#pragma once
/// Reserves a device for one process: a port, a bus address, a network peer.
#include <string>

namespace polyarm::hardware {

/// Reserves a device for this process until destruction. The kernel releases it when the process ends for any
/// reason. Any thread.
class DeviceLock {
 public:
  DeviceLock() = default;
  /// `device`: a path, or any name of an exclusive resource ("/dev/i2c-1:0x60", "192.168.1.10:30004"). Links
  /// in paths are resolved, so two names of one port are the same device. `holder`: name of this process in
  /// the error of another one ("the cell lab, component wheels"). Throws Error("device-in-use") with the
  /// holder, Error("lock-failed") if no lock file can be created.
  DeviceLock(const std::string& device, const std::string& holder);
  ~DeviceLock();
  DeviceLock(DeviceLock&& other) noexcept;
  DeviceLock& operator=(DeviceLock&& other) noexcept;
  DeviceLock(const DeviceLock&) = delete;
  DeviceLock& operator=(const DeviceLock&) = delete;

  bool held() const noexcept { return file_ >= 0; }
  /// For a child process that must keep the device after this process ends: it holds the lock as long as it
  /// has the descriptor. -1: not held.
  int descriptor() const noexcept { return file_; }

  /// The name that the device's holder gave to the lock; empty if no process holds the device, as far as this
  /// user can see. Does not open the device.
  static std::string holder(const std::string& device);

 private:
  int file_ = -1;
};

}  // namespace polyarm::hardware
