#pragma once
/// The names of the interfaces by which sensors are known (the semantic components of ros2_control), and the
/// search for a sensor that has them. Not real-time.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

inline constexpr const char* kImuInterfaces[] = {
    "orientation.x",         "orientation.y",         "orientation.z",        "orientation.w",
    "angular_velocity.x",    "angular_velocity.y",    "angular_velocity.z",                        // rad/s
    "linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"};                    // m/s²
inline constexpr const char* kPoseInterfaces[] = {"position.x",    "position.y",    "position.z",  // m
                                                  "orientation.x", "orientation.y", "orientation.z",
                                                  "orientation.w"};
inline constexpr const char* kForceTorqueInterfaces[] = {"force.x",  "force.y",  "force.z",    // N
                                                         "torque.x", "torque.y", "torque.z"};  // N m
inline constexpr const char* kGpsInterfaces[] = {"status", "service", "latitude", "longitude",
                                                 "altitude"};  // degrees, degrees, m
inline constexpr const char* kGpsCovarianceInterfaces[] = {"latitude_covariance", "longitude_covariance",
                                                           "altitude_covariance"};  // m²

/// A sensor that the state interfaces show.
struct FoundSensor {
  std::string whole;  ///< with its robot: "arm/tcp_fts_sensor"
  std::string name;   ///< as the user calls it: "tcp_fts_sensor"
};

/// Reads the parameter `key` and finds the sensor of that name that has one of `interfaces`, those of
/// the controller's own robot first; without a name the only one. `what` is the kind in words ("an IMU").
/// Throws Error("unknown-sensor") that names the sensors there are.
FoundSensor read_sensor(ControllerContext& context, std::span<const char* const> interfaces,
                        const std::string& what, const std::string& key = "sensor_name");

/// Reads `frame_id`, which is the sensor's name where the file does not say.
std::string read_frame(Parameters& parameters, const std::string& sensor);

/// Reads nine numbers, row by row; all zero where the file does not say.
std::array<double, 9> read_covariance(Parameters& parameters, const std::string& key);

/// The place of `key` in its file, if it stands there.
Location place_of(const Parameters& parameters, const std::string& key);

/// "name[0]" … "name[8]"
void add_covariance_fields(std::vector<std::string>& fields, const std::string& name);

}  // namespace polyarm::controllers
