/// The verb that reads and changes data sets, one text file each. Changes keep everything else in the file.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/client.hpp"
#include "apps/data_teach.hpp"
#include "apps/options.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/file_lookup.hpp"
#include "polyarm/data/formats.hpp"
#include "polyarm/data/literal.hpp"
#include "polyarm/data/set_edit.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
using data::ImportFile;
using data::Value;

struct DataArguments {
  std::string file, name, value, from, to, form, group = "arm";
  std::vector<std::string> names;
  std::size_t steps = 1;
  bool yes = false, json = false;
};

/// The file as named, or with a data file extension if such a file exists.
fs::path set_path(const std::string& file) {
  std::error_code ignored;
  if (fs::exists(file, ignored)) return file;
  for (const std::string& ending : data::file_endings())
    if (fs::exists(file + ending, ignored)) return file + ending;
  return fs::path(file).has_extension() ? file : file + ".data";
}

ImportFile load(const std::string& file) {
  return ImportFile::load(set_path(file).string());
}

/// True if --yes was given or the typed or piped answer is yes. No input means no.
bool agreed(const DataArguments& a, const std::string& question) {
  if (a.yes) return true;
  fmt::print(stderr, "{} [y/N] ", question);
  std::string line;
  if (!std::getline(std::cin, line))
    throw Error("not-asked", "no answer to: " + question, "use --yes if that is intended");
  const std::string answer = lower(trim(line));
  return answer == "y" || answer == "yes";
}

std::string type_of(const Value& value) {
  const std::string type = data::name(value.kind());
  return type.substr(type.find(' ') + 1);
}

void tell(const Problems& problems) {
  for (const Problem& problem : problems.list())
    if (problem.severity == Severity::warning) fmt::print(stderr, "{}\n", problem.text());
}

data::SetForm form_of(const DataArguments& a, const std::string& file) {
  if (a.form.empty()) return data::form_of_file(file);
  if (const auto form = data::form_named(a.form)) return *form;
  throw Error("bad-value", "'" + a.form + "' is not a form of data", "text, csv, json, yaml or srdf");
}

int list_names(const DataArguments& a) {
  const ImportFile set = load(a.file);
  Problems problems;
  if (a.json) {
    fmt::print("{}", data::write_form(set.values(), data::SetForm::json, a.group, problems));
    return kOk;
  }
  const auto& entries = set.values().entries();
  const bool groups =
      std::any_of(entries.begin(), entries.end(), [](const auto& e) { return !e.group.empty(); });
  std::vector<std::vector<std::string>> rows;
  for (const data::Entry& entry : entries) {
    rows.push_back({entry.name, type_of(entry.value), entry.value.text()});
    if (groups) rows.back().insert(rows.back().begin() + 1, entry.group);
  }
  print_table(groups ? std::vector<std::string>{"NAME", "GROUP", "TYPE", "VALUE"}
                     : std::vector<std::string>{"NAME", "TYPE", "VALUE"},
              rows);
  return kOk;
}

/// Asks nothing, because no value changes.
int group_names(const DataArguments& a) {
  const fs::path path = set_path(a.file);
  ImportFile::load(path.string());  // throws if there is no such file
  data::edit_set(path, "group " + a.value + ": " + join(a.names, ", "), [&](ImportFile& set) {
    for (const std::string& each : a.names) set.set_group(each, a.value);
  });
  return kOk;
}

int get_value(const DataArguments& a) {
  const ImportFile set = load(a.file);
  const Value* value = set.values().value(a.name);
  if (!value)
    throw Error(Problem{"unknown-name",
                        {set.file()},
                        "there is no '" + a.name + "'" + did_you_mean(a.name, set.values().names()),
                        {}});
  fmt::print("{}\n", data::literal(*value));
  return kOk;
}

int set_value(const DataArguments& a) {
  const std::string& text = a.value;
  std::string why;
  auto value = data::parse_literal(text, why);
  if (!value)
    throw Error("bad-value", "'" + text + "' is not a value: " + why,
                "for example true, 40mm, '\"a text\"', '[1, 2]', 'pose(0.3, 0, 0.1, 180deg, 0, 0)'");
  const fs::path path = set_path(a.file);
  std::error_code ignored;
  if (fs::exists(path, ignored)) {
    const ImportFile known = ImportFile::load(path.string());
    const Value* old = known.values().value(a.name);
    if (old && !(*old == *value) &&
        !agreed(a, "'" + a.name + "' is " + data::literal(*old) + "; overwrite it?"))
      return kFailed;
  } else if (!agreed(a, "there is no file " + path.string() + "; create it?")) {
    return kFailed;
  }
  data::edit_set(path, "set " + a.name, [&](ImportFile& set) { set.set(a.name, *value); });
  return kOk;
}

int import_values(const DataArguments& a) {
  Problems problems;
  const data::DataSet values = data::read_form(read_file(a.from), form_of(a, a.from), a.from, problems);
  problems.throw_if_errors();
  tell(problems);
  const fs::path path = set_path(a.file);
  std::error_code ignored;
  std::vector<std::string> changed;
  if (fs::exists(path, ignored)) {
    const ImportFile known = ImportFile::load(path.string());
    for (const data::Entry& entry : values.entries())
      if (const Value* old = known.values().value(entry.name); old && !(*old == entry.value))
        changed.push_back(entry.name);
  }
  if (!changed.empty() && !agreed(a, "this overwrites " + join(changed, ", ") + "; continue?"))
    return kFailed;
  data::edit_set(path, "import " + a.from, [&](ImportFile& set) {
    for (const data::Entry& entry : values.entries()) {
      set.set(entry.name, entry.value);
      if (!entry.group.empty()) set.set_group(entry.name, entry.group);
    }
  });
  const bool one = values.size() == 1;
  fmt::print("{} {} from {} {} in {}\n", values.size(), one ? "value" : "values", a.from, one ? "is" : "are",
             path.string());
  return kOk;
}

int export_values(const DataArguments& a) {
  const ImportFile set = load(a.file);
  Problems problems;
  const std::string text =
      data::write_form(set.values(), a.to.empty() && a.form.empty() ? data::SetForm::text : form_of(a, a.to),
                       a.group, problems);
  tell(problems);
  if (a.to.empty()) {
    fmt::print("{}", text);
    return kOk;
  }
  std::error_code ignored;
  if (fs::exists(a.to, ignored) && !agreed(a, a.to + " exists; overwrite it?")) return kFailed;
  write_file_atomically(a.to, text);
  return kOk;
}

int delete_values(const DataArguments& a) {
  const fs::path path = set_path(a.file);
  if (a.name.empty()) {
    read_file(path);  // throws if there is no such file
    if (!agreed(a, "delete the file " + path.string() + "?")) return kFailed;
    data::delete_set(path);
    return kOk;
  }
  const ImportFile known = data::without(ImportFile::load(path.string()), a.name);
  if (!agreed(a, "delete '" + a.name + "' from " + path.string() + "?")) return kFailed;
  data::edit_set(path, "delete " + a.name, [&](ImportFile& set) { set = data::without(set, a.name); });
  return kOk;
}

int show_history(const DataArguments& a) {
  const auto versions = data::history(set_path(a.file));
  if (versions.empty()) {
    fmt::print("no change of this file is known\n");
    return kOk;
  }
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = versions.size(); k > 0; --k)
    rows.push_back({std::to_string(versions.size() - k + 1), versions[k - 1].when, versions[k - 1].what});
  print_table({"UNDO", "WHEN", "CHANGE"}, rows);
  return kOk;
}

int undo_changes(const DataArguments& a) {
  const fs::path path = set_path(a.file);
  const auto versions = data::history(path);
  data::require_history(path, a.steps);
  for (std::size_t k = versions.size(); k > versions.size() - a.steps; --k)
    fmt::print(stderr, "takes back: {}\n", versions[k - 1].what);
  const std::string what =
      a.steps == 1 ? "the last change" : "the last " + std::to_string(a.steps) + " changes";
  if (!agreed(a, "take back " + what + " of " + path.string() + "?")) return kFailed;
  data::undo(path, a.steps);
  return kOk;
}

/// An action of the data editor: its name and its function.
struct Action {
  const char* name;
  const char* text;
  int (*run)(const DataArguments&);
};
constexpr Action kActions[] = {
    {"list", "list the names with types and values", list_names},
    {"get", "print one value in the form that `set` takes", get_value},
    {"set", "change a value, or add one", set_value},
    {"group", "put names into a group", group_names},
    {"import", "import values from a text file, CSV, JSON, YAML or SRDF", import_values},
    {"export", "write the values as text, CSV, JSON, YAML or SRDF", export_values},
    {"delete", "delete a name, or the file", delete_values},
    {"history", "list the changes that can be undone, newest first", show_history},
    {"undo", "undo the last change, or the last N", undo_changes},
};

void add_arguments(CommandLine& sub, const std::string& action, DataArguments& a) {
  sub.add_option("file", a.file, "the data set's file; its ending may be left out")->required();
  if (action == "get" || action == "set") sub.add_option("name", a.name)->required();
  if (action == "delete") sub.add_option("name", a.name, "left out: the whole file");
  if (action == "set")
    sub.add_option("value", a.value, "true, 40mm, \"text\", [1, 2], pose(…), joints(…)")->required();
  if (action == "group") {
    sub.add_option("group", a.value, "its name; \"\": no group")->required();
    sub.add_option("names", a.names)->required();
  }
  if (action == "import") sub.add_option("from", a.from, "the file to read")->required();
  if (action == "export") sub.add_option("--output,-o", a.to, "the file to write; default: print it");
  if (action == "import" || action == "export")
    sub.add_option("--format", a.form, "text, csv, json, yaml or srdf; else by the file's ending");
  if (action == "export") sub.add_option("--group", a.group, "group of an SRDF's states");
  if (action == "undo") sub.add_option("steps", a.steps, "how many");
  if (action == "list") sub.add_flag("--json", a.json, "as JSON");
  if (action != "list" && action != "get" && action != "history" && action != "group")
    sub.add_flag("--yes,-y", a.yes, "do not ask");
}

}  // namespace

int run_data(int argc, char** argv) {
  CommandLine app("Data sets: variables and points in text files", "polyarm data");
  DataArguments arguments;
  TeachArguments teach;
  for (const Action& action : kActions)
    add_arguments(*app.add_subcommand(action.name, action.text), action.name, arguments);
  add_teaching(app, teach);
  app.footer(examples({"polyarm data list examples/pick_and_place/PAPpoints",
                       "polyarm data set points Home 'joints(a = 0, b = 90deg)'",
                       "polyarm data export points -o points.csv", "polyarm data undo points 2",
                       "polyarm data frame points table --from corner along aside",
                       "polyarm data tool points gripper --from t1 t2 t3 t4"}));
  return run_actions(app, argc, argv, [&] {
    const std::string word = app.subcommand();
    for (const Action& action : kActions)
      if (word == action.name) return action.run(arguments);
    return run_teaching(word, teach);
  });
}

}  // namespace polyarm::apps
