/// Requests that record a run.
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/projects.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that recording needs.
struct RecordOwners {
  const CellSetup& setup;
  std::unique_ptr<Recorder>& recorder;
};

Recorder& recorder_of(const RecordOwners& cell) {
  if (Recorder* recorder = cell.recorder.get()) return *recorder;
  throw Error("no-recorder", "this cell was started without a recorder", "run it with polyarm run");
}

RecordFacts facts_of(const RecordStatus& status) {
  return {status.recording, status.file.string(), status.seconds, status.rate,
          status.messages,  status.bytes,         status.lost,    status.problem};
}

/// A request may name a file, but no folder.
std::filesystem::path recording_named(const RecordOwners& cell, const std::string& name) {
  if (name.empty()) return {};
  const std::filesystem::path plain = name;
  if (plain.filename() != plain || name == "." || name == ".." || name.find('\0') != std::string::npos)
    throw Error("bad-argument", "'" + name + "' is not a plain name of a file",
                "recordings go to .state/recordings of the cell");
  const bool has = plain.extension() == ".mcap";
  return cell.setup.file.folder / ".state" / "recordings" / (has ? name : name + ".mcap");
}

RecordFacts record_state(const RecordOwners& cell, const RecordState&) {
  return facts_of(recorder_of(cell).status());
}

/// Limits the number of recordings, because they are only deleted by hand.
void require_room(const RecordOwners& cell) {
  std::size_t count = 0;
  std::error_code error;
  for ([[maybe_unused]] const auto& each :
       std::filesystem::directory_iterator(cell.setup.file.folder / ".state" / "recordings", error))
    ++count;
  if (count >= bounds::kRecordings)
    throw Error("too-many", "the cell has " + std::to_string(count) + " recordings",
                "delete some of .state/recordings");
}

RecordFacts record_start(const RecordOwners& cell, const RecordStart& request) {
  require_room(cell);
  RecordOptions options;
  options.file = recording_named(cell, request.file.value_or(""));
  options.rate = request.rate.value_or(options.rate);
  recorder_of(cell).start(options);
  return facts_of(recorder_of(cell).status());
}

Poll<RecordFacts> record_stop(const RecordOwners& cell, const RecordStop&) {
  recorder_of(cell).stop();
  return [cell] {
    const RecordStatus status = recorder_of(cell).status();
    return status.recording ? Progress<RecordFacts>{} : Progress<RecordFacts>::done(facts_of(status));
  };
}

}  // namespace

std::vector<Handler> record_handlers() {
  return handlers<record_state, record_start, record_stop>();
}

}  // namespace polyarm::cell
