#pragma once
/// A Participant in a process of its own, polyarm_ros2_dds: what parses packets of strangers shares no memory
/// with what moves a robot. When that process ends, for whatever reason, it is started again after a pause
/// with the same endpoints; latched samples are written again, others that were under way are lost.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/process/pulse.hpp"
#include "polyarm/ros2/dds_types.hpp"

namespace polyarm::ros2 {

struct RemoteOptions {
  std::string program;             ///< empty: polyarm_ros2_dds where modules lie
  std::vector<std::string> words;  ///< before the process id of the parent
  /// Before the process is started again: doubled each time, and short again once it has lived for `fine`.
  std::chrono::milliseconds first_pause{100}, longest_pause{5000}, fine{30'000};
  /// Its main loop has not come round for so long (it hands over samples one at a time, and each may take the
  /// library a while): it is ended, and started again.
  std::chrono::milliseconds patience{10'000};
  /// None of its threads has run for so long (process/pulse.hpp): the same.
  std::chrono::milliseconds silence{process::kLongestSilence};
};

struct RemoteStatistics {
  std::uint64_t too_large = 0;  ///< samples that came
  std::uint64_t dropped = 0;    ///< samples that came faster than they were taken
  std::uint64_t unsent = 0;     ///< samples that could not be written
  std::uint64_t losses = 0;     ///< how often the process has ended
};

/// For a person: the process was lost, it is back, an endpoint could not be made.
struct RemoteNews {
  bool good = false;
  std::string what, advice;
};

/// As Participant, with its calls from any thread but those of OnSample; none waits for the other process.
class RemoteParticipant {
 public:
  using Id = std::size_t;

  /// Returns when it speaks DDS. Throws Error("no-dds").
  explicit RemoteParticipant(const ParticipantOptions& options, RemoteOptions remote = {});
  ~RemoteParticipant();
  RemoteParticipant(const RemoteParticipant&) = delete;
  RemoteParticipant& operator=(const RemoteParticipant&) = delete;

  Id add_writer(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, bool addressed = false);
  Id add_reader(const std::string& topic, const std::string& type, const Qos& qos,
                const std::string& user_data, OnSample on_sample);
  /// Ends the endpoint; no OnSample of it is under way any more when this returns.
  void remove(Id id);

  /// Its sequence number with the process that there is now, from 1; 0 where it cannot be handed over: there
  /// is no process just now (latched samples are kept), it is too large, or too much waits.
  std::int64_t write(Id writer, std::span<const std::byte> payload,
                     const std::optional<Related>& related = {});

  /// kNoGuid until the other process has told.
  Guid guid(Id id) const;
  Guid prefix() const;
  std::vector<Remote> matched(Id id) const;
  bool is_matched(Id id) const;
  std::string user_data_of_writer(const Guid& writer) const;
  std::size_t known() const;
  /// Somebody else has a writer of this topic and type ("rt/cmd_vel", "std_msgs::msg::dds_::Int32_").
  bool is_offered(const std::string& topic, const std::string& type) const;

  /// Whether all endpoints have their guids, or could not be made.
  bool settled() const;
  /// Counts up when guids of endpoints have changed.
  std::uint64_t identities() const;
  RemoteStatistics statistics() const;
  /// Each once; a process that is lost again and again is told of once a minute.
  std::vector<RemoteNews> take_news();
  /// How long there has been no process; zero where there is one.
  std::chrono::nanoseconds missing_for() const;
  /// Its process id; 0 where there is none.
  int process() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::ros2
