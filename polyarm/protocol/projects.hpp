#pragma once
/// Requests about the project's files, the text of programs, other cells, and recordings.
#include "polyarm/base/pose.hpp"
#include "polyarm/protocol/controllers.hpp"
#include "polyarm/protocol/facts.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/problem.hpp"
#include "polyarm/protocol/programs.hpp"

namespace polyarm::protocol {

struct ListedFile {
  std::string name, kind;
  std::uint64_t bytes = 0;
  double modified_s = 0;  ///< Unix time
  std::string hash;
  bool running = false, draft = false;
  POLYARM_MEMBERS(ListedFile, name, kind, bytes, modified_s, hash, running, draft)
};

struct FilesList {
  static constexpr Facts kFacts{
      .name = "files", .role = Role::watch, .text = "Lists the files of the project."};
  struct Answer {
    static constexpr const char* kOf = "FilesList";
    std::string folder;
    std::vector<ListedFile> files;
    OrNull<std::string> main;  ///< the script of the program
    POLYARM_MEMBERS(Answer, folder, files, main)
  };
  POLYARM_MEMBERS(FilesList)
};

/// An unsaved edit of a file.
struct FileDraft {
  std::string text, base, by;  ///< `base`: hash of the file on which the edit is based
  double saved_s = 0;          ///< Unix time
  POLYARM_MEMBERS(FileDraft, text, base, by, saved_s)
};

struct FilesRead {
  static constexpr Facts kFacts{
      .name = "files.read", .role = Role::watch, .text = "Returns a file, and its unsaved draft."};
  std::string name;
  struct Answer {
    static constexpr const char* kOf = "FilesRead";
    std::string name, text, hash;
    bool running = false;
    OrNull<FileDraft> draft;
    POLYARM_MEMBERS(Answer, name, text, hash, running, draft)
  };
  POLYARM_MEMBERS(FilesRead, name)
};

struct FilesDraft {
  static constexpr Facts kFacts{
      .name = "files.draft",
      .role = Role::program,
      .text =
          "Stores an edit beside the file without changing the file. `base` is the hash of the text "
          "that the edit began with. Without `text`, the draft is deleted."};
  std::string name;
  std::optional<std::string> text, base, by;
  struct Answer {
    static constexpr const char* kOf = "FilesDraft";
    double saved_s = 0;
    POLYARM_MEMBERS(Answer, saved_s)
  };
  POLYARM_MEMBERS(FilesDraft, name, text, base, by)
};

struct FilesWrite {
  static constexpr Facts kFacts{
      .name = "files.write",
      .role = Role::program,
      .text =
          "Writes a file and keeps the previous text as a version. Refused as changed-meanwhile if its "
          "hash is not `base` (empty: a new file), unless `force`.",
      .moves = true};
  std::string name, text;
  std::optional<std::string> base;
  bool force = false;
  struct Answer {
    static constexpr const char* kOf = "FilesWrite";
    std::string name, hash;
    POLYARM_MEMBERS(Answer, name, hash)
  };
  POLYARM_MEMBERS(FilesWrite, name, text, base, force)
};

struct FileVersion {
  int number = 0;
  std::string when, what;
  std::uint64_t bytes = 0;
  POLYARM_MEMBERS(FileVersion, number, when, what, bytes)
};

struct FilesVersions {
  static constexpr Facts kFacts{.name = "files.versions",
                                .role = Role::watch,
                                .text = "Lists the earlier versions of a file, newest first."};
  std::string name;
  struct Answer {
    static constexpr const char* kOf = "FilesVersions";
    std::string name;
    std::vector<FileVersion> versions;
    POLYARM_MEMBERS(Answer, name, versions)
  };
  POLYARM_MEMBERS(FilesVersions, name)
};

struct FilesVersion {
  static constexpr Facts kFacts{
      .name = "files.version", .role = Role::watch, .text = "Returns an earlier version of a file."};
  std::string name;
  double number = 0;
  struct Answer {
    static constexpr const char* kOf = "FilesVersion";
    std::string name;
    int number = 0;
    std::string text;
    POLYARM_MEMBERS(Answer, name, number, text)
  };
  POLYARM_MEMBERS(FilesVersion, name, number)
};

struct FilesDelete {
  static constexpr Facts kFacts{.name = "files.delete",
                                .role = Role::program,
                                .text = "Deletes a file. Its versions remain.",
                                .moves = true};
  std::string name;
  using Answer = JustName;
  POLYARM_MEMBERS(FilesDelete, name)
};

struct FilesRename {
  static constexpr Facts kFacts{
      .name = "files.rename", .role = Role::program, .text = "Renames a file.", .moves = true};
  std::string name, to;
  using Answer = JustName;
  POLYARM_MEMBERS(FilesRename, name, to)
};

struct WordText {
  std::string name, role, form, meaning;
  bool in_tests = false;
  POLYARM_MEMBERS(WordText, name, role, form, meaning, in_tests)
};
struct FunctionText {
  std::string name, signature, meaning;
  bool in_tests = false;
  POLYARM_MEMBERS(FunctionText, name, signature, meaning, in_tests)
};

struct LanguageWords {
  static constexpr Facts kFacts{.name = "language.words",
                                .role = Role::watch,
                                .text = "Lists every word and function of the program language."};
  struct Answer {
    static constexpr const char* kOf = "LanguageWords";
    std::vector<WordText> words;
    std::vector<FunctionText> functions;
    POLYARM_MEMBERS(Answer, words, functions)
  };
  POLYARM_MEMBERS(LanguageWords)
};

/// A finding in a file.
struct Finding {
  std::string code;
  FindingSeverity severity = FindingSeverity::error;
  std::string file;
  int line = 0, column = 0;
  std::string what, advice;
  std::optional<FactValues> facts;  ///< the variable parts of `what`
  POLYARM_MEMBERS(Finding, code, severity, file, line, column, what, advice, facts)
};

struct ProgramCheck {
  static constexpr Facts kFacts{
      .name = "program.check",
      .role = Role::watch,
      .text = "Checks a program, from its file or from `text`, and lists the problems."};
  std::string name;
  std::optional<std::string> text;
  struct Answer {
    static constexpr const char* kOf = "ProgramCheck";
    std::vector<Finding> problems;
    POLYARM_MEMBERS(Answer, problems)
  };
  POLYARM_MEMBERS(ProgramCheck, name, text)
};

/// A statement of a program.
struct StatementFacts {
  std::string kind;
  int line = 0, end = 0, depth = 0;
  std::string text, name;
  std::vector<std::string> points;
  POLYARM_MEMBERS(StatementFacts, kind, line, end, depth, text, name, points)
};

struct ProgramSteps {
  static constexpr Facts kFacts{
      .name = "program.steps",
      .role = Role::watch,
      .text = "Returns the statements of a program as a list, each with its lines."};
  std::string name;
  std::optional<std::string> text;
  struct Answer {
    static constexpr const char* kOf = "ProgramSteps";
    std::vector<StatementFacts> steps;
    std::vector<Finding> problems;
    POLYARM_MEMBERS(Answer, steps, problems)
  };
  POLYARM_MEMBERS(ProgramSteps, name, text)
};

struct KnownName {
  std::string name, kind, text;
  POLYARM_MEMBERS(KnownName, name, kind, text)
};

struct ProgramNames {
  static constexpr Facts kFacts{.name = "program.names",
                                .role = Role::watch,
                                .text = "Lists every name that a program of this cell may use."};
  struct Answer {
    static constexpr const char* kOf = "ProgramNames";
    std::vector<KnownName> names;
    std::uint64_t version = 0;
    POLYARM_MEMBERS(Answer, names, version)
  };
  POLYARM_MEMBERS(ProgramNames)
};

struct CellRestart {
  static constexpr Facts kFacts{
      .name = "cell.restart",
      .role = Role::administer,
      .text =
          "Stops on the path and builds the cell anew from its files, if you wish with another `robot` "
          "(MODEL or NAME=MODEL), `hardware`, `program` or `cell`. Parts return to their initial "
          "places.",
      .moves = true};
  std::optional<std::string> robot, hardware, program, cell;
  using Answer = Asked;
  POLYARM_MEMBERS(CellRestart, robot, hardware, program, cell)
};

/// The path of the TCP in a rehearsal of a program.
struct RehearsedWay {
  std::string robot;
  int line = 0;
  double seconds = 0;
  std::vector<Vec3> points;
  POLYARM_MEMBERS(RehearsedWay, robot, line, seconds, points)
};
struct RehearsedContacts {
  bool checked = false;
  std::vector<std::string> unchecked;
  double seconds = 0;
  bool whole = false;  ///< true if the physics run reached the program's end
  POLYARM_MEMBERS(RehearsedContacts, checked, unchecked, seconds, whole)
};

struct ProgramDry {
  static constexpr Facts kFacts{
      .name = "program.dry",
      .role = Role::watch,
      .text =
          "Goes through a program, from its file or from `text`, without moving anything. Reports "
          "impossible moves, the path of the TCP (two passes of its loop), and contacts in physics (one "
          "pass)."};
  std::string name;
  std::optional<std::string> text;
  struct Answer {
    static constexpr const char* kOf = "ProgramDry";
    std::vector<Finding> problems;
    std::size_t moves = 0;
    OrNull<FileLine> reached;
    std::vector<RehearsedWay> paths;
    OrNull<double> seconds;
    RehearsedContacts contacts;
    POLYARM_MEMBERS(Answer, problems, moves, reached, paths, seconds, contacts)
  };
  POLYARM_MEMBERS(ProgramDry, name, text)
};

struct CellCheck {
  static constexpr Facts kFacts{
      .name = "cell.check",
      .role = Role::watch,
      .text = "Checks the present files of the cell, like `polyarm check`, and lists the problems."};
  struct Answer {
    static constexpr const char* kOf = "CellCheck";
    std::vector<Finding> problems;
    std::size_t points = 0, moves = 0;
    POLYARM_MEMBERS(Answer, problems, points, moves)
  };
  POLYARM_MEMBERS(CellCheck)
};

/// Something outside the cell's folder that its files refer to.
struct WantedThing {
  std::string kind, what, why, sha256;
  bool allowed = false;
  POLYARM_MEMBERS(WantedThing, kind, what, why, sha256, allowed)
};

struct CellReach {
  static constexpr Facts kFacts{
      .name = "cell.reach",
      .role = Role::administer,
      .text =
          "Lists what the files of a cell access outside its folder: plugins, hosts, devices, files, "
          "secrets. The cell is the open one, or the one in `folder` (`cells` lists them). `allow` "
          "allows hosts (host:NAME) and secrets (secret:NAME) of the list from the next opening on. "
          "`unread` is the problem of a file that could not be read, and that may name more.",
      .watch_without = "allow"};
  std::optional<std::string> folder;
  std::optional<Names> allow;
  struct Answer {
    static constexpr const char* kOf = "CellReach";
    std::vector<WantedThing> wants;
    OrNull<std::string> unread;
    POLYARM_MEMBERS(Answer, wants, unread)
  };
  POLYARM_MEMBERS(CellReach, folder, allow)
};

struct KnownCell {
  std::string name, folder, title;
  std::vector<std::string> robots;
  bool recent = false;
  POLYARM_MEMBERS(KnownCell, name, folder, title, robots, recent)
};

struct CellsList {
  static constexpr Facts kFacts{
      .name = "cells",
      .role = Role::watch,
      .text =
          "Lists the cells that can be opened: those beside the open one, those of the user, and those "
          "opened lately."};
  struct Answer {
    static constexpr const char* kOf = "CellsList";
    std::string open;
    std::vector<KnownCell> cells;
    POLYARM_MEMBERS(Answer, open, cells)
  };
  POLYARM_MEMBERS(CellsList)
};

struct NameAndFolder {
  std::string name, folder;
  POLYARM_MEMBERS(NameAndFolder, name, folder)
};

struct CellSaveAs {
  static constexpr Facts kFacts{
      .name = "cell.save_as",
      .role = Role::administer,
      .text = "Copies the files of the cell to a new cell of the user, without opening it.",
      .moves = true};
  std::string name;
  using Answer = NameAndFolder;
  POLYARM_MEMBERS(CellSaveAs, name)
};

struct CellNew {
  static constexpr Facts kFacts{
      .name = "cell.new",
      .role = Role::administer,
      .text =
          "Creates a cell of the user with a table, a robot of the catalogue and an empty program, "
          "without opening it.",
      .moves = true};
  std::string name, robot;
  using Answer = NameAndFolder;
  POLYARM_MEMBERS(CellNew, name, robot)
};

struct DeviceFacts {
  std::string parameter, path;
  bool there = false;
  POLYARM_MEMBERS(DeviceFacts, parameter, path, there)
};
struct RealHardware {
  std::string robot, component, driver, drives;
  std::vector<DeviceFacts> devices;
  POLYARM_MEMBERS(RealHardware, robot, component, driver, drives, devices)
};

struct CellConnect {
  static constexpr Facts kFacts{
      .name = "cell.connect",
      .role = Role::administer,
      .text =
          "Without `real`: returns the real hardware that the cell names, and whether it can be "
          "connected. With `real`: builds the cell anew, on that hardware (held and disarmed), or "
          "simulated.",
      .moves = true,
      .watch_without = "real"};
  std::optional<bool> real;
  struct Answer {
    static constexpr const char* kOf = "CellConnect";
    bool real = false;
    std::vector<RealHardware> hardware;
    bool possible = false;
    std::string why, advice;
    OrNull<ProblemFacts> problem;  ///< the reason as a problem; null: possible
    std::optional<std::string> asked;
    POLYARM_MEMBERS(Answer, real, hardware, possible, why, advice, problem, asked)
  };
  POLYARM_MEMBERS(CellConnect, real)
};

struct RecordFacts {
  bool recording = false;
  std::string file;
  double seconds = 0, rate = 0;
  std::uint64_t messages = 0, bytes = 0, lost = 0;
  std::string problem;
  POLYARM_MEMBERS(RecordFacts, recording, file, seconds, rate, messages, bytes, lost, problem)
};

struct RecordState {
  static constexpr Facts kFacts{
      .name = "record",
      .role = Role::watch,
      .text = "Reports whether the cell is recorded, and the size of the recording."};
  using Answer = RecordFacts;
  POLYARM_MEMBERS(RecordState)
};

struct RecordStart {
  static constexpr Facts kFacts{
      .name = "record.start",
      .role = Role::operate,
      .text =
          "Starts a recording with this file name in .state/recordings of the cell, `rate` times a "
          "second (100)."};
  std::optional<std::string> file;
  std::optional<double> rate;
  using Answer = RecordFacts;
  POLYARM_MEMBERS(RecordStart, file, rate)
};

struct RecordStop {
  static constexpr Facts kFacts{
      .name = "record.stop", .role = Role::operate, .text = "Closes the recording."};
  using Answer = RecordFacts;
  POLYARM_MEMBERS(RecordStop)
};

struct HelpArgument {
  std::string name, type;
  bool needed = false;
  POLYARM_MEMBERS(HelpArgument, name, type, needed)
};
struct HelpRow {
  std::string request;
  std::vector<HelpArgument> arguments;
  std::string result, text;
  bool moves = false;
  POLYARM_MEMBERS(HelpRow, request, arguments, result, text, moves)
};

struct Help {
  static constexpr Facts kFacts{.name = "help",
                                .role = Role::watch,
                                .text = "Returns all requests of the cell, with arguments and results."};
  using Answer = std::vector<HelpRow>;
  POLYARM_MEMBERS(Help)
};

}  // namespace polyarm::protocol
