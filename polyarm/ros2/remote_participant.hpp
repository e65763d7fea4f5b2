#pragma once
/// A Participant in a separate process, polyarm_ros2_dds: code that parses packets from the network shares no
/// memory with code that moves a robot. When that process ends for any reason, it is started again after a
/// pause with the same endpoints. Latched samples are written again; other samples in transit are lost.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/participant/dds_types.hpp"
#include "polyarm/process/pulse.hpp"

namespace polyarm::ros2 {

struct RemoteOptions {
  std::string program;             ///< empty: polyarm_ros2_dds in the folder of modules
  std::vector<std::string> words;  ///< arguments before the parent's process id
  /// Pause before a restart. It doubles each time, and is short again once the process has run for `fine`.
  std::chrono::milliseconds first_pause{100}, longest_pause{5000}, fine{30'000};
  /// If the process's main loop makes no progress for this long, it is killed and started again. (It hands
  /// over samples one at a time, and each may take the library a while.)
  std::chrono::milliseconds patience{10'000};
  /// The same if none of its threads has run for this long (process/pulse.hpp).
  std::chrono::milliseconds silence{process::kLongestSilence};
};

struct RemoteStatistics {
  std::uint64_t too_large = 0;  ///< received samples that were too large
  std::uint64_t dropped = 0;    ///< received samples that came faster than they were taken
  std::uint64_t unsent = 0;     ///< samples that could not be written
  std::uint64_t losses = 0;     ///< how often the process has ended
};

/// Reports for the user: the process was lost, it is back, or an endpoint could not be made.
struct RemoteReport {
  bool good = false;
  std::string what, advice;
};

/// The interface of Participant. Call from any thread except inside an OnSample callback; no call waits for
/// the other process.
class RemoteParticipant {
 public:
  using Id = std::size_t;

  /// Returns when the process speaks DDS. Throws Error("no-dds").
  explicit RemoteParticipant(const ParticipantOptions& options, RemoteOptions remote = {});
  ~RemoteParticipant();
  RemoteParticipant(const RemoteParticipant&) = delete;
  RemoteParticipant& operator=(const RemoteParticipant&) = delete;

  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed = false);
  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample);
  /// Ends the endpoint. No OnSample call of it is running when this returns.
  void remove(Id id);

  /// Returns the sequence number within the current process, from 1. Returns 0 if the sample cannot be handed
  /// over: there is no process now (latched samples are kept), it is too large, or the channel is full.
  std::int64_t write(Id writer, std::span<const std::byte> payload,
                     const std::optional<Related>& related = {});

  /// kNoGuid until the other process has reported it.
  Guid guid(Id id) const;
  Guid prefix() const;
  std::vector<Remote> matched(Id id) const;
  bool is_matched(Id id) const;
  std::string user_data_of_writer(const Guid& writer) const;
  std::size_t known() const;
  /// True if another participant has a writer of this topic and type ("rt/cmd_vel",
  /// "std_msgs::msg::dds_::Int32_").
  bool is_offered(const std::string& topic, const std::string& type) const;

  /// True if every endpoint has its guid, or could not be made.
  bool settled() const;
  /// Increases whenever guids of endpoints change.
  std::uint64_t identities() const;
  RemoteStatistics statistics() const;
  /// Returns each report once. A process that is lost repeatedly is reported once a minute.
  std::vector<RemoteReport> take_reports();
  /// How long there has been no process; zero if it runs.
  std::chrono::nanoseconds missing_for() const;
  /// Process id; 0 if there is no process.
  int process() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
