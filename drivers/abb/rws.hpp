#pragma once
/// Robot Web Services of ABB, versions 1 (IRC5) and 2 (OmniCore): states, program, signals, event log, files.
/// One thread at a time; each call waits for the controller's answer.
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/abb/words.hpp"
#include "drivers/wire/http_client.hpp"

namespace polyarm::abb {

struct RwsSettings {
  wire::HttpSettings http;
  int version = 2;
  Nanoseconds interval = 55'000'000;  ///< between two requests; the controller takes about 20 a second
};

/// What the panel and the program show, in the controller's own words.
struct RwsState {
  std::string control;  ///< motoron, motoroff, guardstop, emergencystop, …
  std::string mode;     ///< AUTO, MANR, MANF
  std::string program;  ///< running, stopped
  double speed_ratio = 1;
};

struct RwsIdentity {
  std::string software;  ///< "7.10.0"
  std::vector<std::string> options;
  /// The option of Externally Guided Motion is among them.
  bool guided() const;
  bool recent() const;  ///< RobotWare 6.07.01 or newer
};

/// An entry of the event log.
struct RwsEvent {
  long sequence = 0;
  int kind = 1;  ///< 1: information, 2: warning, 3: error
  int code = 0;
  std::string title;
};

/// Texts of `<span class="NAME">` in an answer. Passes over everything else.
std::vector<std::string> rws_values(std::string_view body, std::string_view name);
/// The first of them; empty without one.
std::string rws_value(std::string_view body, std::string_view name);
/// The entries of an event log, at most bounds::kEventLogEntries.
std::vector<RwsEvent> rws_events(std::string_view body);

class Rws {
 public:
  struct Failure {
    Cause cause = Cause::none;
    int detail = 0;
    std::string text;
  };
  explicit Rws(RwsSettings settings) : settings_(settings), http_(std::move(settings.http)) {}

  /// Each returns false, or nothing, after a failure; failure() has its cause.
  bool identify(RwsIdentity& out);
  bool read_state(RwsState& out);
  std::optional<std::array<double, 6>> joints();  ///< degrees
  bool has_module(const std::string& task, const std::string& module);
  bool motors(bool on);
  bool reset_pointer();
  bool start_program(bool forever = false);
  bool stop_program();
  bool set_speed_ratio(double share);
  std::optional<bool> signal(const std::string& name);
  bool set_signal(const std::string& name, bool on);
  /// The newest entry first; those of `after` and older are left out.
  std::optional<std::vector<RwsEvent>> events(long after = 0);
  bool put_file(const std::string& name, const std::string& text);
  bool load_module(const std::string& task, const std::string& file);
  bool log_out();

  const Failure& failure() const { return failure_; }
  const wire::HttpClient& http() const { return http_; }
  void close() { http_.close(); }

 private:
  std::optional<std::string> get(const std::string& path, const std::string& what);
  bool post(const std::string& path, const std::string& form, const std::string& what);
  std::optional<wire::HttpMessage> ask(const std::string& method, const std::string& path,
                                       const std::string& body, const std::string& what);
  bool fail(const wire::HttpMessage& answer, const std::string& what);
  /// With the right to edit; gives it back afterwards.
  template <typename Work>
  bool as_master(Work work);
  bool second() const { return settings_.version == 2; }

  RwsSettings settings_;
  wire::HttpClient http_;
  Failure failure_;
  Nanoseconds last_ = 0;
};

}  // namespace polyarm::abb
