#pragma once
/// Reads the `links:` section of signals.yaml. Example:
///
///   links:
///     plc:
///       modbus: client                  # or server: the PLC connects to us
///       host: 127.0.0.1                 # beyond this machine only with `beyond_loopback: true`
///       port: 502
///       unit: 1
///       poll: 50ms
///       timeout: 500ms
///       word_order: high_first          # of numbers with several registers; or low_first
///       groups: {slow: 1s}
///       on_loss: hold                   # or go_on
///       tags:
///         ActivateGripper: {coil: 0, direction: both}
///         PartHeld: {coil: 1, direction: out}
///         Temperature: {input: 3, format: int16, scale: 0.1, range: [-40, 120], group: slow}
///         pinput: {holding: 20, format: float32, type: pose, length: mm, angle: deg, direction: in}
///     broker:
///       mqtt: client
///       tls: {ca: ca.pem, certificate: cell.pem, key: cell.key}
///       will: {topic: cell/state, text: gone}
///       tags:
///         PartKind: {topic: vision/kind, type: text, direction: in, stale: 5s}
///         pinput: {topic: vision/pose, type: pose, json: true, direction: in}
///         Count: {topic: cell/count, type: number, json: true, field: count.total, direction: out,
///                 retain: true}
///     camera:
///       ros2: node                      # joins its graph; domain, range, peers, namespace, distribution
///       tags:
///         pick: {topic: /camera/part, message: geometry_msgs/PoseStamped, type: pose, direction: in}
///         Count: {topic: /cell/count, message: std_msgs/Int32, field: data, type: number, direction: out}
///         Look: {call: /camera/look, service: std_srvs/Trigger}
///         Found: {answer: /camera/look, field: success, direction: in}
#include <vector>

#include "polyarm/signals/link.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::signals {

/// Reads the links under `node`; mistakes go to `problems`. File names are relative to `folder`.
std::vector<LinkEntry> read_links(const Yaml& node, const std::filesystem::path& folder, Problems& problems);
/// `{within: [[x, y, z], [x, y, z]]}`
PoseRange read_range(const Yaml& node);

}  // namespace polyarm::signals
