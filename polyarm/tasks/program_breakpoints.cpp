/// Breakpoints of a cell's programs.
#include <filesystem>
#include <utility>

#include "polyarm/tasks/programs.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

/// Path relative to the folder if the file is inside it; otherwise unchanged.
std::string name_in_folder(const fs::path& folder, const std::string& file) {
  std::error_code error;
  const std::string name = fs::proximate(file, folder, error).generic_string();
  return error || name.empty() || name.starts_with("..") ? file : name;
}

bool is_script_of(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const fs::path path(name);
  return !path.is_absolute() && !name.starts_with("..") && path.extension() == ".script" &&
         fs::is_regular_file(folder / path, error);
}

}  // namespace

void Programs::keep_breakpoints(const FileBreakpoints& of_file) {
  const std::string name = name_in_folder(setup_.file.folder, of_file.file);
  if (is_script_of(setup_.file.folder, name)) breakpoints_.of(name) = {name, of_file.lines, of_file.text};
}

std::vector<Location> Programs::breakpoints() const {
  std::vector<Location> out = breakpoints_.all();
  for (Location& each : out)
    if (!fs::path(each.file).is_absolute()) each.file = (setup_.file.folder / each.file).string();
  return out;
}

std::vector<FileBreakpoints> Programs::kept_breakpoints() const {
  std::vector<FileBreakpoints> out = breakpoints_.files();
  for (FileBreakpoints& each : out) each.file = (setup_.file.folder / each.file).string();
  return out;
}

const TextLines* Programs::lines_of_program(const std::string& file) const {
  return program_ ? program_->interpreter().lines_of(file) : nullptr;
}

/// Converts a line of `text` (a text that the program was read from) to a line of the newest known text of
/// the file.
int Programs::known_line(FileBreakpoints& file, int line, const std::optional<TextLines>& text) const {
  const TextLines* const read = lines_of_program(file.file);
  if (!file.text && text && (!read || *read != *text)) file.text = read ? *read : *text;
  const TextLines* const told = text ? &*text : read;
  if (!file.text || !told || *told == *file.text) return line;
  const std::vector<int> at = where_lines_are(*told, *file.text);
  const int there = line <= static_cast<int>(at.size()) ? at[static_cast<std::size_t>(line - 1)] : 0;
  return there > 0 ? there : line;
}

void Programs::add_breakpoint(const Location& place, const std::optional<TextLines>& text) {
  const std::string name = name_in_folder(setup_.file.folder, place.file);
  const TextLines* const read = lines_of_program(name);
  if (!read && plc_ && plc_->interpreter().has_file(name))
    throw Error("bad-argument", place.file + " is the PLC's script, which does not pause");
  if (!read && !is_script_of(setup_.file.folder, name))
    throw Error("unknown-file",
                "no program has a file '" + place.file + "', and the cell's folder has no such script",
                "name a script of the cell, as the list of files does");
  int line = place.line;
  if (read && (!text || *text == *read)) {
    const std::vector<Location> found = program_->interpreter().set_breakpoints({{name, line, 0}});
    place_breakpoints();
    if (found.empty())
      throw Error("bad-argument", "no statement begins at or after line " + std::to_string(line) + " of " +
                                      place.file + ": nothing would pause there");
    line = found.front().line;
  }
  FileBreakpoints& file = breakpoints_.of(name_in_folder(setup_.file.folder, name));
  file.add(known_line(file, line, text));
  place_breakpoints();
}

void Programs::drop_breakpoint(const Location& place, const std::optional<TextLines>& text) {
  FileBreakpoints* const file = breakpoints_.find(name_in_folder(setup_.file.folder, place.file));
  if (!file) return;
  file->drop(known_line(*file, place.line, text));
  place_breakpoints();
}

void Programs::clear_breakpoints() {
  for (FileBreakpoints& each : breakpoints_.files()) each.lines.clear();
  place_breakpoints();
}

void Programs::edit_breakpoints(const std::string& file, TextLines text,
                                const std::optional<std::vector<int>>& lines) {
  const std::string name = name_in_folder(setup_.file.folder, file);
  if (!breakpoints_.find(name) && (!lines || lines->empty())) return;
  if (!is_script_of(setup_.file.folder, name))
    throw Error("unknown-file", "the cell's folder has no script '" + file + "'",
                "name a script of the cell, as the list of files does");
  FileBreakpoints& there = breakpoints_.of(name);
  if (lines) {
    there.lines.clear();
    for (const int line : *lines) there.add(line);
    there.text = std::move(text);
  } else {
    if (const TextLines* const read = lines_of_program(name); read && !there.text) there.text = *read;
    there.follow(std::move(text));
  }
  place_breakpoints();
}

/// Sets the breakpoints in the present program. If its text is the newest, they move down to the next
/// statements.
void Programs::place_breakpoints() {
  if (!program_) return;
  program::Interpreter& interpreter = program_->interpreter();
  std::vector<Location> wanted;
  std::vector<FileBreakpoints*> same;
  for (FileBreakpoints& each : breakpoints_.files()) {
    const TextLines* const read = interpreter.lines_of(each.file);
    if (!read) continue;
    FileBreakpoints here = each;
    if (each.text && *each.text != *read)
      here.follow(*read);
    else
      same.push_back(&each);
    for (const int line : here.lines) wanted.push_back({each.file, line, 0});
  }
  const std::vector<Location> placed = interpreter.set_breakpoints(wanted);
  for (FileBreakpoints* each : same) {
    each->lines.clear();
    for (const Location& at : placed)
      if (name_in_folder(setup_.file.folder, at.file) == each->file) each->add(at.line);
  }
}

}  // namespace polyarm::cell
