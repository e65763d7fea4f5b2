#include "polyarm/recording/live_view.hpp"

#include <chrono>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/recording/cell_channels.hpp"

namespace polyarm::recording {

namespace {

constexpr Nanoseconds kEvery = 20'000'000, kSeldom = 1'000'000'000;
constexpr std::uintmax_t kLargestAsset = 64u << 20;

std::int64_t system_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Mesh files by the URI in the descriptions; clients can read no other files.
class Meshes {
 public:
  explicit Meshes(const cell::CellView& cell) {
    for (const auto& robot : cell.robots())
      for (const description::Link& link : robot->model.links)
        for (const auto* shapes : {&link.visuals, &link.collisions})
          for (const description::Shape& shape : *shapes)
            if (!shape.mesh_path.empty()) paths_[shape.mesh] = shape.mesh_path;
  }

  Asset read(const std::string& uri) const {
    const auto at = paths_.find(uri);
    if (at == paths_.end()) return {std::nullopt, "no robot of this cell has a mesh '" + uri + "'"};
    std::error_code error;
    if (std::filesystem::file_size(at->second, error) > kLargestAsset)
      return {std::nullopt, "the mesh " + at->second + " is larger than 64 MB"};
    try {
      return {read_file(at->second), {}};
    } catch (const Error& e) {
      return {std::nullopt, e.what()};
    }
  }

 private:
  std::map<std::string, std::string> paths_;
};

}  // namespace

class LiveView::Work : public cell::Observer {
 public:
  Work(cell::CellView& cell, FoxgloveServer& server)
      : cell_(cell),
        server_(server),
        channels_(cell, cell.lock_step() ? 0 : system_time() - cell.now()),
        meshes_(std::make_shared<const Meshes>(cell)),
        worker_(std::make_shared<cell::Worker>(false)) {
    server_.set_own_time(cell.lock_step());
    server_.set_channels(channels_.list());
    std::map<std::string, nlohmann::json> parameters;
    for (const auto& robot : cell.robots())
      parameters[cell.robots().size() == 1 ? "robot_description" : robot->entry.name + ".robot_description"] =
          description::write_plain_urdf(robot->model);
    server_.set_parameters(std::move(parameters));
    server_.set_assets(
        [meshes = meshes_, worker = worker_](const std::string& uri, std::function<void(Asset)> reply) {
          worker->post([meshes, uri, reply = std::move(reply)] { reply(meshes->read(uri)); });
        });
    channels_.record_latched(cell.now(), tell());
    cell_.add_observer(*this);
  }
  ~Work() override {
    cell_.remove_observer(*this);
    server_.set_assets(nullptr);
    server_.set_parameters({});
    server_.set_channels({});
  }

  bool serve() {
    given_ = std::exchange(announced_, false);
    if (server_.clients() == 0) return false;
    const Nanoseconds now = cell_.now();
    const bool seldom = now - reported_seldom_ >= kSeldom;
    if (seldom) {
      reported_seldom_ = now;
      channels_.record_health(now, tell());
      server_.report_time(now);
    }
    channels_.report_tags(now, seldom, tell());
    channels_.record_parts(now, seldom, tell());
    channels_.record_bases(now, tell());
    if (now - reported_at_ < kEvery) return given_;
    reported_at_ = now;
    const control::Snapshot& seen = cell_.snapshot();
    control::TappedCycle cycle;
    cycle.index = seen.cycle.index;
    cycle.time = seen.cycle.time;
    cycle.late = cell_.health().late;
    cycle.cost = cell_.health().cost.percentile(0.5);
    cycle.state = seen.state;
    cycle.cause = seen.cause;
    cycle.standing = seen.standing;
    channels_.record_sample(cycle, seen.states, seen.commands, tell());
    channels_.record_interfaces(seen.cycle.time, seen.states, tell());
    return given_;
  }

 private:
  WriteMessage tell() {
    return [this](std::size_t channel, std::int64_t time, std::span<const std::byte> payload) {
      given_ = server_.publish(channel, time, payload) || given_;
    };
  }
  void log(Nanoseconds time, LogLevel level, const std::string& who, const std::string& text,
           const Location& where = {}) {
    if (server_.clients() == 0) return;
    channels_.record_log(time, level, who, text, where, tell());
    announced_ = announced_ || given_;
  }

  void on_note(const std::string& text) override {
    log(cell_.now(), LogLevel::info, "cell", without_secrets(text));
  }
  void on_line(Nanoseconds time, const std::string& task, const Location& where,
               const std::string& source) override {
    if (server_.clients() == 0) return;
    channels_.record_line(time, task, where, source, tell());
    announced_ = announced_ || given_;
  }
  void on_log(Nanoseconds time, const std::string& task, const std::string& text) override {
    log(time, LogLevel::info, task, text);
  }
  void on_state(Nanoseconds time, const std::string& state, const Problem& cause) override {
    log(time, LogLevel::info, "cell", cause.what.empty() ? state : state + ": " + cause.what);
  }
  void on_problem(Nanoseconds time, const Problem& problem) override {
    const std::string advice = problem.advice.empty() ? "" : " [" + problem.advice + "]";
    log(time, problem.severity == Severity::error ? LogLevel::error : LogLevel::warn, problem.code,
        problem.what + advice, problem.where);
  }

  cell::CellView& cell_;
  FoxgloveServer& server_;
  CellChannels channels_;
  std::shared_ptr<const Meshes> meshes_;
  std::shared_ptr<cell::Worker> worker_;
  bool given_ = false, announced_ = false;
  Nanoseconds reported_at_ = -kEvery, reported_seldom_ = -kSeldom;
};

LiveView::LiveView(cell::CellView& cell, FoxgloveServer& server)
    : work_(std::make_unique<Work>(cell, server)) {}
LiveView::~LiveView() = default;
bool LiveView::serve() {
  return work_->serve();
}

}  // namespace polyarm::recording
