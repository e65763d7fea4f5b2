/// Requests that record what the cell does.
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

namespace {

Recorder& recorder_of(Cell& cell) {
  if (Recorder* recorder = cell.recorder()) return *recorder;
  throw Error("no-recorder", "whoever runs this cell records nothing", "run it with polyarm run");
}

Json status_json(const RecordStatus& status) {
  return {{"recording", status.recording}, {"file", status.file.string()}, {"seconds", status.seconds},
          {"rate", status.rate},           {"messages", status.messages},  {"bytes", status.bytes},
          {"lost", status.lost},           {"problem", status.problem}};
}

/// Who asks from afar names a file, and never a place.
std::filesystem::path recording_named(const Cell& cell, const std::string& name) {
  if (name.empty()) return {};
  const std::filesystem::path plain = name;
  if (plain.filename() != plain || name == "." || name == ".." || name.find('\0') != std::string::npos)
    throw Error("bad-argument", "'" + name + "' is no plain name of a file",
                "recordings go to .state/recordings of the cell");
  const bool has = plain.extension() == ".mcap";
  return cell.file().folder / ".state" / "recordings" / (has ? name : name + ".mcap");
}

Poll record_state(Cell& cell, const Json&) {
  return at_once(status_json(recorder_of(cell).status()));
}

/// Recordings are deleted by hand alone.
void require_room(const Cell& cell) {
  std::size_t count = 0;
  std::error_code error;
  for ([[maybe_unused]] const auto& each :
       std::filesystem::directory_iterator(cell.file().folder / ".state" / "recordings", error))
    ++count;
  if (count >= bounds::kRecordings)
    throw Error("too-many", "the cell has " + std::to_string(count) + " recordings",
                "delete some of .state/recordings");
}

Poll record_start(Cell& cell, const Json& arguments) {
  require_room(cell);
  RecordOptions options;
  options.file = recording_named(cell, text_argument(arguments, "file", ""));
  options.rate = number_argument(arguments, "rate", options.rate);
  recorder_of(cell).start(options);
  return at_once(status_json(recorder_of(cell).status()));
}

Poll record_stop(Cell& cell, const Json&) {
  recorder_of(cell).stop();
  return [](Cell& c) {
    const RecordStatus status = recorder_of(c).status();
    return status.recording ? Progress{} : Progress::done(status_json(status));
  };
}

constexpr const char* kRecord = "{recording, file, seconds, rate, messages, bytes, lost, problem}";

}  // namespace

const std::vector<RequestRow>& record_rows() {
  static const std::vector<RequestRow> table = {
      {{"record", {}, kRecord, "whether the cell is recorded, and what that has come to", false},
       record_state},
      {{"record.start",
        {{"file", kText}, {"rate", kNumber}},
        kRecord,
        "record into a file of this name in .state/recordings of the cell, `rate` times a second (100)",
        false},
       record_start},
      {{"record.stop", {}, kRecord, "close the recording", false}, record_stop},
  };
  return table;
}

}  // namespace polyarm::cell
