#include "polyarm/recording/cell_recorder.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <ctime>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/machine/stops.hpp"
#include "polyarm/recording/attachments.hpp"
#include "polyarm/recording/cell_channels.hpp"
#include "polyarm/recording/file_sink.hpp"
#include "polyarm/recording/mcap_writer.hpp"

namespace polyarm::recording {

namespace fs = std::filesystem;

namespace {

constexpr Nanoseconds kChunk = 1'000'000'000;    // longest time that a message waits for the file, ns
constexpr Nanoseconds kInterfaces = 10'000'000;  // shortest time between two messages of
                                                 // /dynamic_joint_states, ns
constexpr std::size_t kMostEvents = bounds::kRecorderEventBytes;    // bytes queued for the thread
constexpr std::size_t kMostRowBytes = bounds::kRecorderCycleBytes;  // bytes of cycles queued for the thread
constexpr auto kNap = std::chrono::milliseconds(50);

std::int64_t system_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// One recording file. Functions called by the cell thread never wait for the disk.
class Session {
 public:
  Session(cell::CellView& cell, const fs::path& path, double rate, const std::string& version)
      : cell_(cell),
        lock_step_(cell.lock_step()),
        begin_(cell.now()),
        reported_all_(cell.now()),
        rate_(rate),
        sink_(path),
        writer_(sink_, {"ros2", "polyarm " + version}),
        channels_(cell, lock_step_ ? 0 : system_time() - cell.now()) {
    for (const Channel& channel : channels_.list()) writer_.add_channel(channel);
    const double cycles = 1e9 / static_cast<double>(cell.period());
    const auto every = static_cast<unsigned>(std::max(1.0, std::round(cycles / rate)));
    rate_ = cycles / every;
    const std::size_t values = cell.table().built_states() + cell.table().built_commands();
    const std::size_t row = sizeof(double) * values + sizeof(control::TappedCycle);
    const auto rows = static_cast<std::size_t>(std::max(256.0, 4 * rate_));
    tap_ = cell.make_tap(std::min(rows, std::max<std::size_t>(16, kMostRowBytes / row)), every);
    facts_ = {{"version", version},
              {"cell", cell.file().name},
              {"clock", lock_step_ ? "lock-step" : "wall clock"},
              {"loop_hz", format_number(cycles)},
              {"recorded_hz", format_number(rate_)},
              {"begin_s", format_number(seconds(begin_))}};
    channels_.report_tags(begin_, true, events());
    cell.tap(tap_.get());
    if (lock_step_)
      write_head();
    else
      thread_ = std::thread([this] { run(); });
  }

  ~Session() {
    close();
    may_end();
    if (thread_.joinable()) thread_.join();
    // A control thread that hangs may still write to the tap later, so the tap is leaked.
    if (!untapped_ || !untapped_->done()) static_cast<void>(tap_.release());
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Queues messages of the cell thread.
  WriteMessage events() {
    return [this](std::size_t channel, std::int64_t time, std::span<const std::byte> payload) {
      const std::lock_guard lock(mutex_);
      if (waiting_bytes_ + payload.size() > kMostEvents) {
        lost_.fetch_add(1, std::memory_order_relaxed);
        return;
      }
      waiting_bytes_ += payload.size();
      waiting_.push_back({channel, time, {payload.begin(), payload.end()}});
    };
  }
  CellChannels& channels() { return channels_; }

  void tick(Nanoseconds now) {
    const bool all = now - reported_all_ >= kChunk;
    if (all) reported_all_ = now;
    channels_.report_tags(now, all, events());
    channels_.record_parts(now, all, events());
    channels_.record_bases(now, events());
    if (all) channels_.record_health(now, events());
    if (lock_step_) pass();
  }

  /// Stops taking messages and writes those that are queued. Call it again until closed() is true: the
  /// control thread must release the tap first. In lock-step it closes at once.
  void close() {
    closes_ = true;
    if (closed()) return;
    Problems busy;  // if it fails, the next tick tries again
    if (!untapped_) collect(busy, [this] { untapped_ = cell_.tap(nullptr); });
    if (lock_step_) {
      pass();
      end();
    } else if (untapped_ && untapped_->done()) {
      may_end();
    }
  }
  bool closes() const { return closes_; }
  bool closed() const { return closed_.load(std::memory_order_acquire); }

  cell::RecordStatus status() const {
    cell::RecordStatus out;
    out.recording = !closed();
    out.seconds = seconds((closed() ? ended_at_.load() : cell_.now()) - begin_);
    out.rate = rate_;
    out.messages = messages_.load(std::memory_order_relaxed);
    out.bytes = bytes_.load(std::memory_order_relaxed);
    out.lost = lost_.load(std::memory_order_relaxed) + tap_->lost();
    const std::lock_guard lock(mutex_);
    out.problem = problem_;
    return out;
  }
  /// Returned once.
  std::optional<std::string> take_problem() {
    const std::lock_guard lock(mutex_);
    if (problem_.empty() || std::exchange(announced_, true)) return std::nullopt;
    return problem_;
  }

 private:
  struct Event {
    std::size_t channel;
    std::int64_t time;
    std::vector<std::byte> payload;
  };

  void may_end() {
    const std::lock_guard lock(mutex_);
    may_end_ = true;
    wake_.notify_one();
  }

  void run() {
    write_head();
    for (bool last = false; !last;) {
      {
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, kNap, [this] { return may_end_; });
        last = may_end_;
      }
      pass();
    }
    end();
  }

  /// The metadata, attachments and latched messages, which a reader needs before other messages.
  void write_head() {
    writer_.metadata("polyarm", facts_);
    const auto time = static_cast<std::uint64_t>(lock_step_ ? begin_ : system_time());
    for (const AttachedFile& each : files_of(cell_.file())) {
      std::string text;
      try {
        text = read_file(each.path);
        if (is_secret(each.path, text)) continue;
        text = without_secrets(text);
      } catch (const Error&) {
        continue;  // the file has been deleted in the meantime
      }
      writer_.attachment(each.name, media_type_of(each.name), time, text);
    }
    for (const auto& robot : cell_.robots())
      writer_.attachment(robot->entry.name + ".urdf", "application/xml", time,
                         without_secrets(description::write_urdf(robot->model)));
    channels_.record_latched(begin_, into_file());
    find_problem();
  }

  /// Writes everything received so far, ordered by time.
  void pass() {
    std::deque<Event> events;
    {
      const std::lock_guard lock(mutex_);
      events.swap(waiting_);
      waiting_bytes_ = 0;
    }
    const WriteMessage tell = into_file();
    const std::int64_t offset = channels_.offset();
    for (const control::TappedCycle* row; (row = tap_->front()) != nullptr; tap_->drop()) {
      for (; !events.empty() && events.front().time <= row->time + offset; events.pop_front())
        write(events.front().channel, events.front().time, events.front().payload);
      channels_.record_sample(*row, tap_->states(), tap_->commands(), tell);
      if (row->time >= next_interfaces_) {
        next_interfaces_ = row->time + kInterfaces;
        channels_.record_interfaces(row->time, tap_->states(), tell);
      }
    }
    for (const Event& event : events) write(event.channel, event.time, event.payload);
    end_chunk_in_time();
  }

  WriteMessage into_file() {
    return [this](std::size_t channel, std::int64_t at, std::span<const std::byte> payload) {
      write(channel, at, payload);
    };
  }
  void write(std::size_t channel, std::int64_t time, std::span<const std::byte> payload) {
    if (writer_.chunk_is_empty()) chunk_begun_ = time;
    newest_ = std::max(newest_, time);
    writer_.message(channel, static_cast<std::uint64_t>(std::max<std::int64_t>(time, 0)), payload);
  }

  void end_chunk_in_time() {
    const std::int64_t now = lock_step_ ? newest_ : system_time();
    if (!writer_.chunk_is_empty() && now - chunk_begun_ >= kChunk - (lock_step_ ? 0 : kMargin))
      writer_.end_chunk();
    messages_.store(writer_.messages(), std::memory_order_relaxed);
    bytes_.store(writer_.bytes(), std::memory_order_relaxed);
    find_problem();
  }

  void find_problem() {
    if (!writer_.failed()) return;
    const std::lock_guard lock(mutex_);
    if (problem_.empty())
      problem_ = "nothing more is recorded: " + sink_.problem() +
                 "; the run continues, and the file is readable up to here";
  }

  void end() {
    writer_.finish();
    sink_.flush();
    messages_.store(writer_.messages(), std::memory_order_relaxed);
    bytes_.store(writer_.bytes(), std::memory_order_relaxed);
    find_problem();
    ended_at_ = std::max(newest_ - channels_.offset(), begin_);
    closed_.store(true, std::memory_order_release);
  }

  static constexpr Nanoseconds kMargin = 200'000'000;  // the thread also needs time to sleep and to write

  cell::CellView& cell_;
  const bool lock_step_;
  const Nanoseconds begin_;
  Nanoseconds reported_all_;
  double rate_;
  std::unique_ptr<control::CycleTap> tap_;
  std::shared_ptr<realtime::Job> untapped_;
  bool closes_ = false;

  // Used by the recording thread; in lock-step by the tick.
  FileSink sink_;
  McapWriter writer_;
  CellChannels channels_;
  std::map<std::string, std::string> facts_;
  std::int64_t chunk_begun_ = 0, newest_ = 0;
  Nanoseconds next_interfaces_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Event> waiting_;
  std::size_t waiting_bytes_ = 0;
  bool may_end_ = false, announced_ = false;
  std::string problem_;
  std::atomic<std::uint64_t> messages_{0}, bytes_{0}, lost_{0};
  std::atomic<Nanoseconds> ended_at_{0};
  std::atomic<bool> closed_{false};
  std::thread thread_;
};

class CellRecorder : public cell::Recorder, private cell::Observer {
 public:
  CellRecorder(cell::CellView& cell, std::string version) : cell_(cell), version_(std::move(version)) {
    cell_.add_observer(*this);
  }
  ~CellRecorder() override { cell_.remove_observer(*this); }

  void start(const cell::RecordOptions& options) override {
    if (session_ && !session_->closed())
      throw Error("recording", "the cell is being recorded into " + path_.string(), "stop that first");
    if (!(options.rate > 0 && std::isfinite(options.rate)))
      throw Error("bad-value", "a recording cannot have " + format_number(options.rate) + " cycles a second",
                  "give a rate from 0.1 Hz to that of the control loop");
    const fs::path path = options.file.empty() ? new_file() : options.file;
    session_.reset();
    session_ = std::make_unique<Session>(cell_, path, options.rate, version_);
    path_ = path;
  }

  void stop() override {
    if (session_) session_->close();
  }

  cell::RecordStatus status() const override {
    cell::RecordStatus out = session_ ? session_->status() : cell::RecordStatus{};
    out.file = path_;
    return out;
  }

  void tick(Nanoseconds now) override {
    if (!session_) return;
    if (session_->closes())
      session_->close();
    else
      session_->tick(now);
    if (const auto problem = session_->take_problem())
      cell_.observer().on_problem(
          now, {"recording", {}, *problem, "make room and record again", Severity::warning});
  }

 private:
  /// `NAME-20261122-001500.mcap`; in lock-step, which has no clock, `NAME.mcap`, `NAME-2.mcap`.
  fs::path new_file() const {
    const fs::path folder = cell_.file().folder / ".state" / "recordings";
    std::string name = cell_.file().name;
    if (!cell_.lock_step()) {
      const std::time_t now = std::time(nullptr);
      std::tm parts{};
      ::gmtime_r(&now, &parts);
      char text[32];
      std::strftime(text, sizeof text, "-%Y%m%d-%H%M%S", &parts);
      name += text;
    }
    std::error_code error;
    fs::create_directories(folder, error);
    const fs::path ignored = folder.parent_path() / ".gitignore";
    if (!fs::exists(ignored, error)) write_file_atomically(ignored, "*\n");
    fs::path path = folder / (name + ".mcap");
    for (int n = 2; fs::exists(path, error); ++n) path = folder / (name + "-" + std::to_string(n) + ".mcap");
    return path;
  }

  void log(Nanoseconds time, LogLevel level, const std::string& who, const std::string& text,
           const Location& where = {}) {
    if (session_ && !session_->closes())
      session_->channels().record_log(time, level, who, text, where, session_->events());
  }

  void on_note(const std::string& text) override {
    log(cell_.now(), LogLevel::info, "cell", without_secrets(text));
  }
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override {
    if (session_ && !session_->closes())
      session_->channels().record_line(time, task, where, source, session_->events());
  }
  void on_tag(Nanoseconds time, const std::string& name, const std::string& value,
              const std::string& who) override {
    log(time, LogLevel::debug, who, name + " = " + value);
  }
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    log(time, LogLevel::info, task, text);
  }
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override {
    log(time, LogLevel::info, "cell", cause.what.empty() ? state : state + ": " + cause.what);
  }
  void on_stop(Nanoseconds time, const cell::StopReport& stop) override {
    log(time, LogLevel::info, "cell", stop.sentence());
  }
  void on_question(const std::string& text) override { log(cell_.now(), LogLevel::info, "cell", text); }
  void on_problem(Nanoseconds time, const Problem& problem) override {
    const std::string advice = problem.advice.empty() ? "" : " [" + problem.advice + "]";
    log(time, problem.severity == Severity::error ? LogLevel::error : LogLevel::warn, problem.code,
        problem.what + advice, problem.where);
  }

  cell::CellView& cell_;
  std::string version_;
  fs::path path_;
  std::unique_ptr<Session> session_;
};

}  // namespace

std::unique_ptr<cell::Recorder> make_recorder(cell::CellView& cell, std::string version) {
  return std::make_unique<CellRecorder>(cell, std::move(version));
}

}  // namespace polyarm::recording
