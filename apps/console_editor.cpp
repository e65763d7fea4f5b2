#include "apps/console_editor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/data/frame_chain.hpp"
#include "polyarm/data/point_frames.hpp"

namespace polyarm::apps {

namespace fs = std::filesystem;
using data::ImportFile;
using data::Kind;
using data::Value;

namespace {

bool is_data_ending(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending == ".points" || ending == ".data" || ending == ".txt";
}

/// The text without the values called `name` and without the lines that mention them.
std::string without(const std::string& text, const std::string& name) {
  std::string out, current;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1);
    const std::string line = text.substr(at, end + 1 - at);
    at = end + 1;
    const auto colon = line.find(':');
    const std::string key = colon == std::string::npos ? "" : lower(trim(line.substr(0, colon)));
    if (key == "name") current = std::string(trim(line.substr(colon + 1)));
    const bool value = key == "bool" || key == "num" || key == "text" || key == "point";
    if (current == name && (key == "name" || value)) continue;
    out += line;
  }
  return out;
}

}  // namespace

// --- files ------------------------------------------------------------------------------------------------

std::string ConsoleEditor::summary() const {
  const std::string name = path_.empty() ? "no file yet" : path_.filename().string();
  const std::size_t count = file_.values().size();
  return fmt::format("{}{}  {} value{}", name, has_unsaved() ? " * (not saved)" : "", count,
                     count == 1 ? "" : "s");
}

std::vector<std::string> ConsoleEditor::files() const {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error))
    if (is_data_ending(entry.path()) && entry.is_regular_file(error)) out.push_back(entry.path().filename());
  std::sort(out.begin(), out.end());
  return out;
}

std::optional<fs::path> ConsoleEditor::find(const std::string& name) const {
  try {
    const fs::path path = data::find_file(name, folder_);
    return path.extension() == ".script" ? std::nullopt : std::optional(path);
  } catch (const Error&) {
    return std::nullopt;
  }
}

fs::path ConsoleEditor::path_for(const std::string& name) const {
  if (is_data_ending(name)) return folder_ / name;
  const auto& entries = file_.values().entries();
  const bool points =
      !entries.empty() &&
      std::all_of(entries.begin(), entries.end(), [](const data::Entry& e) { return e.value.is_place(); });
  return folder_ / (name + (points ? ".points" : ".data"));
}

void ConsoleEditor::begin(const fs::path& path) {
  Problems none;
  file_ = ImportFile::parse("", path.string(), none);
  path_ = path;
  saved_.clear();
}

void ConsoleEditor::open(const fs::path& path) {
  ImportFile opened = ImportFile::load(path.string());  // throws for a broken file, and keeps the open one
  file_ = std::move(opened);
  path_ = path;
  saved_ = file_.text();
  talk_.say(fmt::format("{}: {} values", path.filename().string(), file_.values().size()));
}

void ConsoleEditor::load() {
  if (!may_leave()) return;
  list_files();
  const std::string name = talk_.name("Name of the file to load: ");
  if (const auto path = find(name)) return open(*path);
  if (fs::exists(folder_ / name))
    throw Error("not-data", "'" + name + "' is not a data file", "data files end in .points, .data or .txt");
  if (!talk_.yes("There is no file '" + name + "'" + did_you_mean(name, files()) + ". Create it?")) return;
  Problems none;
  file_ = ImportFile::parse("", name, none);
  begin(path_for(name));
  talk_.say(path_.filename().string() + " is new; it is written when you save it");
}

void ConsoleEditor::write(const fs::path& path) {
  const std::string text = file_.text();
  write_file_atomically(path, text);
  path_ = path;
  saved_ = text;
  talk_.say(fmt::format("saved {} values in {}", file_.values().size(), path.filename().string()));
}

void ConsoleEditor::save() {
  if (path_.empty()) return save_as();
  std::error_code error;
  if (fs::exists(path_, error) && read_file(path_) != saved_ &&
      !talk_.yes(path_.filename().string() + " was changed by somebody else meanwhile. Overwrite it?"))
    throw GivenUp{};
  write(path_);
}

void ConsoleEditor::save_as() {
  const fs::path path = path_for(talk_.name("Name to save it as: "));
  std::error_code error;
  const bool own = !path_.empty() && path == path_;
  if (fs::exists(path, error) && !own &&
      !talk_.yes(path.filename().string() + " exists already. Overwrite it?"))
    throw GivenUp{};
  write(path);
}

void ConsoleEditor::list_files() const {
  const std::vector<std::string> all = files();
  if (all.empty()) return talk_.say("there are no data files in " + folder_.string());
  fmt::print("{}", in_columns(all));
}

void ConsoleEditor::delete_file() {
  list_files();
  const std::string name = talk_.name("Name of the file to delete: ");
  const auto path = find(name);
  if (!path || !is_data_ending(*path))
    throw Error("no-file", "there is no data file '" + name + "'" + did_you_mean(name, files()));
  if (!talk_.yes("Delete " + path->filename().string() + "? It cannot be restored.")) throw GivenUp{};
  std::error_code error;
  if (!fs::remove(*path, error)) throw Error("unwritable", path->string() + ": " + error.message());
  const bool open = *path == path_;
  if (open) begin({});
  talk_.say("deleted " + path->filename().string() + (open ? "; no file is open now" : ""));
}

bool ConsoleEditor::may_leave() {
  if (!has_unsaved()) return true;
  const std::string name = path_.empty() ? "What is in the editor" : path_.filename().string();
  for (;;) {
    const std::string answer =
        lower(talk_.line(name + " has changes that are not saved. Save them? (y, n, Enter: stay): "));
    if (answer.empty()) return false;
    if (answer == "n" || answer == "no") return true;
    if (answer != "y" && answer != "yes") {
      talk_.complain("'" + answer + "' is neither y nor n");
      continue;
    }
    try {
      save();
      return true;
    } catch (const GivenUp&) {
      return false;
    } catch (const Error& e) {  // a full disk or a read-only folder
      talk_.complain(e);
      return false;
    }
  }
}

std::optional<fs::path> ConsoleEditor::rescue() {
  if (!has_unsaved()) return std::nullopt;
  const std::string stem = path_.empty() ? "editor" : path_.stem().string();
  fs::path beside = folder_ / (stem + ".unsaved.txt");
  for (int i = 2; fs::exists(beside); ++i) beside = folder_ / fmt::format("{}.unsaved-{}.txt", stem, i);
  write_file_atomically(beside, file_.text());
  saved_ = file_.text();
  return beside;
}

// --- values -----------------------------------------------------------------------------------------------

void ConsoleEditor::set(const std::string& name, const Value& value) {
  file_.set(name, value);
  Problems none;  // parse again, so the next point uses the format at the end of the file
  file_ = ImportFile::parse(file_.text(), file_.file(), none);
}

std::string ConsoleEditor::keep(const Value& value) {
  std::string name = talk_.line("Name for it: ");
  for (; !name.empty(); name = talk_.line("Name for it: ")) {
    if (!values().find(name) ||
        talk_.yes("'" + name + "' exists already: " + values().value(name)->text() + ". Overwrite it?")) {
      set(name, value);
      talk_.say(fmt::format("{} = {}", name, value.text()));
      return name;
    }
    if (!talk_.yes("Choose another name?")) break;
  }
  talk_.say(talk_.dim("it was not kept"));
  return "";
}

data::JointState ConsoleEditor::joints_of(const Json& state) {
  data::JointState out;
  for (const Json& joint : state["names"]) {
    out.names.push_back(joint.get<std::string>());
    out.positions.push_back(state["joints"][out.names.back()].get<double>());
  }
  return out;
}

data::Point ConsoleEditor::pose_of(const Json& state) {
  const Json &p = state["position"], &q = state["orientation"];
  const auto at = [](const Json& list, std::size_t i) { return list[i].get<double>(); };
  return {{{at(p, 0), at(p, 1), at(p, 2)}, normalized({at(q, 0), at(q, 1), at(q, 2), at(q, 3)})}, false};
}

data::JointState ConsoleEditor::ask_joints() {
  data::JointState out;
  for (const RobotSource::Joint& joint : robot_.joints()) {
    out.names.push_back(joint.name);
    out.positions.push_back(
        talk_.quantity(joint.name + ": ", joint.slides ? Dimension::length : Dimension::angle));
  }
  return out;
}

data::Point ConsoleEditor::ask_pose() {
  std::vector<double> xyz;
  for (const char* axis : {"x", "y", "z"})
    xyz.push_back(talk_.quantity(std::string(axis) + ": ", Dimension::length));
  for (;;) {
    const std::string form = lower(talk_.line("RPY or Quaternion (Enter: RPY): "));
    if (form.empty() || form == "rpy") break;
    if (form != "quaternion") {
      talk_.complain("'" + form + "' is neither RPY nor Quaternion");
      continue;
    }
    Quaternion q;
    for (const auto& [name, part] : {std::pair{"qx", &q.x}, {"qy", &q.y}, {"qz", &q.z}, {"qw", &q.w}})
      *part = talk_.quantity(std::string(name) + ": ", Dimension::none);
    const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    if (!(std::abs(length - 1) < 0.01))
      throw Error("bad-point", fmt::format("this quaternion has the length {:.4g}, not 1", length),
                  "no rotation is 0, 0, 0, 1");
    return {{{xyz[0], xyz[1], xyz[2]}, normalized(q)}, true};
  }
  std::vector<double> rpy;
  for (const char* axis : {"roll", "pitch", "yaw"})
    rpy.push_back(talk_.quantity(std::string(axis) + ": ", Dimension::angle));
  return {pose_xyz_rpy({xyz[0], xyz[1], xyz[2]}, {rpy[0], rpy[1], rpy[2]}), false};
}

/// Asks for a boolean, number or text, in the syntax of a data file.
Value ConsoleEditor::ask_value(Kind kind, const std::string& question) {
  const char* key = kind == Kind::boolean ? "Bool: " : kind == Kind::number ? "Num: " : "Text: ";
  for (;;) {
    const std::string answer = talk_.name(question);
    Problems problems;
    const ImportFile read = ImportFile::parse(std::string("Name: value\n") + key + answer, "", problems);
    if (const Value* value = read.values().value("value")) return *value;
    for (const Problem& problem : problems.list()) talk_.complain(problem.what + "; " + problem.advice);
  }
}

void ConsoleEditor::import() {
  list_files();
  const std::string name = talk_.name("Text file to import: ");
  const auto path = find(name);
  if (!path) throw Error("no-file", "there is no file '" + name + "'" + did_you_mean(name, files()));
  Problems problems;
  const ImportFile read = ImportFile::parse(read_file(*path), path->string(), problems);
  problems.throw_if_errors();
  for (const Problem& warning : problems.list()) talk_.say(warning.text());
  std::size_t replaced = 0;
  if (values().empty()) {  // into an empty file: unchanged, with comments
    file_ = ImportFile::parse(file_.text() + read.text(), file_.file(), problems);
  } else {
    for (const data::Entry& entry : read.values().entries()) {
      replaced += values().find(entry.name) ? 1 : 0;
      file_.set(entry.name, entry.value);
    }
    Problems none;
    file_ = ImportFile::parse(file_.text(), file_.file(), none);
  }
  talk_.say(
      fmt::format("imported {} values of {}{}", read.values().size(), path->filename().string(),
                  replaced > 0 ? fmt::format(", {} of them over those of the same name", replaced) : ""));
}

void ConsoleEditor::remove() {
  const std::string name = talk_.name("Name of the value to delete: ");
  const Value* value = values().value(name);
  if (!value)
    throw Error("unknown-name", "there is no '" + name + "'" + did_you_mean(name, values().names()));
  if (!talk_.yes("Delete " + name + " = " + value->text() + "?")) throw GivenUp{};
  Problems none;
  file_ = ImportFile::parse(without(file_.text(), name), file_.file(), none);
  talk_.say("deleted " + name);
}

void ConsoleEditor::list_keys() const {
  if (values().empty()) return talk_.say("there are no values");
  std::vector<std::vector<std::string>> rows;
  for (const data::Entry& entry : values().entries()) {
    std::string kind = data::name(entry.value.kind());
    kind = kind.substr(kind.find(' ') + 1);
    rows.push_back({entry.name, kind, entry.value.text()});
  }
  print_table({"NAME", "KIND", "VALUE"}, rows);
}

/// Edits the parts of a value one by one, showing the present ones.
void ConsoleEditor::edit() {
  const std::string name = talk_.name("Name of the value to edit: ");
  const Value* value = values().value(name);
  if (!value)
    throw Error("unknown-name", "there is no '" + name + "'" + did_you_mean(name, values().names()));
  talk_.say(name + " = " + value->text());
  const auto part = [&](const std::string& what, double now, Dimension dimension) {
    return talk_.quantity(fmt::format("{} ({}): ", what, format_number(now)), dimension, now);
  };
  if (const data::JointState* joints = value->as_joints()) {
    data::JointState changed = *joints;
    std::vector<RobotSource::Joint> known;
    try {
      known = robot_.joints();
    } catch (const Error&) {  // without a robot the units in the file decide
    }
    for (std::size_t j = 0; j < changed.positions.size(); ++j) {
      const std::string joint = j < changed.names.size() ? changed.names[j] : fmt::format("joint {}", j + 1);
      const auto own =
          std::find_if(known.begin(), known.end(), [&](const auto& each) { return each.name == joint; });
      const bool slides = own == known.end() ? changed.given_at(j) == Dimension::length : own->slides;
      const Dimension dimension = slides ? Dimension::length : Dimension::angle;
      changed.positions[j] = part(joint, changed.positions[j], dimension);
      if (own != known.end()) changed.note_given(j, dimension);
    }
    set(name, changed);
  } else if (const data::Point* point = value->as_point()) {
    const Vec3 p = point->pose.position, r = to_rpy(point->pose.rotation);
    const Vec3 xyz{part("x", p.x, Dimension::length), part("y", p.y, Dimension::length),
                   part("z", p.z, Dimension::length)};
    const Vec3 rpy{part("roll", r.x, Dimension::angle), part("pitch", r.y, Dimension::angle),
                   part("yaw", r.z, Dimension::angle)};
    const bool turned = rpy.x != r.x || rpy.y != r.y || rpy.z != r.z;
    data::Point changed = *point;  // it stays in its frame, and keeps its tool and robot
    changed.pose = {xyz, turned ? from_rpy(rpy.x, rpy.y, rpy.z) : point->pose.rotation};
    if (changed.taught && !(changed.pose == point->pose)) {  // its joints no longer fit
      auto taught = std::make_shared<data::Taught>(*changed.taught);
      taught->joints = {};
      changed.taught = std::move(taught);
    }
    set(name, changed);
  } else {
    set(name, ask_value(value->kind(), "New value: "));
  }
  talk_.say(name + " = " + values().value(name)->text());
}

Value outermost(const Value& value, const data::DataSet& of) {
  const data::Point* const point = value.as_point();
  if (!point || point->frame().empty()) return value;
  const data::FrameChain chain = data::frame_chain(point->frame(), [&](const std::string& name) {
    const Value* frame = of.value(name);
    return frame ? frame->as_point() : nullptr;
  });
  data::Point out = data::converted(*point, chain.root, chain.pose.rotation * data::axes_of(*point));
  out.pose = chain.pose * out.pose;
  return out;
}

Value ConsoleEditor::value_of(const std::string& file, const std::string& name) {
  const auto path = find(file);
  if (!path) throw Error("no-file", "there is no file '" + file + "'" + did_you_mean(file, files()));
  ImportFile read;
  const bool open = *path == path_;
  if (!open) read = ImportFile::load(path->string());
  const data::DataSet& set = open ? values() : read.values();
  const Value* value = set.value(name);
  if (!value)
    throw Error("unknown-name",
                path->filename().string() + " has no '" + name + "'" + did_you_mean(name, set.names()));
  return outermost(*value, set);
}

void ConsoleEditor::run() {
  const auto store = [this](auto ask) { return [this, ask] { keep(ask()); }; };
  talk_.menu(
      [this] { return "File Editor   " + summary(); },
      [this, store]() -> std::vector<MenuEntry> {
        return {
            {1, "Load File", [this] { load(); }},
            {2, "Save File", [this] { save(); }},
            {3, "Save File as", [this] { save_as(); }},
            {4, "List Files in Directory", [this] { list_files(); }},
            {5, "Delete Data File", [this] { delete_file(); }},
            {6, "Save Current JS", store([this] { return Value(joints_of(robot_.state())); })},
            {7, "Save Current Pose", store([this] { return Value(pose_of(robot_.state())); })},
            {8, "Save Input JS", store([this] { return Value(ask_joints()); })},
            {9, "Save Input Pose", store([this] { return Value(ask_pose()); })},
            {10, "Save Input Boolean", store([this] { return ask_value(Kind::boolean, "True or False: "); })},
            {11, "Save Input Number", store([this] { return ask_value(Kind::number, "Number: "); })},
            {12, "Save Input Text", store([this] { return ask_value(Kind::text, "Text: "); })},
            {13, "Import From Text File", [this] { import(); }},
            {14, "Delete Point", [this] { remove(); }},
            {15, "List Keys", [this] { list_keys(); }},
            {16, "Edit Value", [this] { edit(); }},
        };
      });
}

}  // namespace polyarm::apps
