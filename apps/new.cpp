#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "apps/options.hpp"
#include "apps/templates.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;

/// What the words of the templates become.
struct Names {
  std::string kind, name, type, vendor;
};

bool is_snake(const std::string& word) {
  const auto fits = [](char c) {
    return std::islower(static_cast<unsigned char>(c)) || std::isdigit(static_cast<unsigned char>(c)) ||
           c == '_';
  };
  return !word.empty() && std::islower(static_cast<unsigned char>(word.front())) && word.back() != '_' &&
         word.find("__") == std::string::npos && std::all_of(word.begin(), word.end(), fits);
}

/// "MyArm" → "my_arm"; what is written so already stays.
std::string snake(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (std::isupper(c) && i > 0 && name[i - 1] != '_' &&
        !std::isupper(static_cast<unsigned char>(name[i - 1])))
      out += '_';
    out += static_cast<char>(std::tolower(c));
  }
  return out;
}

/// "my_arm" → "MyArm"
std::string camel(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i)
    if (name[i] != '_')
      out += i == 0 || name[i - 1] == '_'
                 ? static_cast<char>(std::toupper(static_cast<unsigned char>(name[i])))
                 : name[i];
  return out;
}

Names names_of(const std::string& kind, const std::string& given, const std::string& vendor) {
  Names out{kind, snake(given), camel(snake(given)), vendor.empty() ? snake(given) : vendor};
  // These are names of targets that CMake has itself.
  static const std::vector<std::string> kTaken = {"all", "clean", "help", "install", "package", "test"};
  if (!is_snake(out.name) || std::find(kTaken.begin(), kTaken.end(), out.name) != kTaken.end())
    throw Error("bad-name", "'" + given + "' cannot be the name",
                "use small letters, digits and '_', beginning with a letter: my_arm");
  if (!is_snake(out.vendor))
    throw Error("bad-name", "'" + vendor + "' cannot be the vendor",
                "use small letters, digits and '_', beginning with a letter: acme");
  return out;
}

/// The words of the templates in one pass, so that a name may hold one of them.
std::string filled(const std::string& text, const Names& names) {
  const std::pair<std::string, const std::string&> words[] = {
      {"my_device", names.name}, {"MyDevice", names.type}, {"my_vendor", names.vendor}};
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto found = std::find_if(std::begin(words), std::end(words), [&](const auto& word) {
      return text.compare(at, word.first.size(), word.first) == 0;
    });
    if (found == std::end(words)) {
      out += text[at++];
    } else {
      out += found->second;
      at += found->first.size();
    }
  }
  return out;
}

void write(const fs::path& folder, const Names& names) {
  std::error_code error;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    throw Error("exists", folder.string() + " is there already, nothing was written",
                "choose another folder with --folder DIR, or another name");
  fs::create_directories(folder, error);
  if (error) throw Error("unwritable", folder.string() + " cannot be made: " + error.message());
  for (const TemplateFile& file : template_files())
    if (names.kind == file.kind)
      write_file_atomically(folder / filled(file.name, names), filled(file.text, names));
}

/// How CMake finds this very Polyarm: its build folder, or where it is installed.
std::string find_option() {
  std::error_code error;
  const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  return fs::exists(here / "polyarmConfig.cmake", error)
             ? "-Dpolyarm_DIR=" + here.string()
             : "-DCMAKE_PREFIX_PATH=" + here.parent_path().string();
}

}  // namespace

int run_new(int argc, char** argv) {
  CommandLine app(
      "Writes a starting point for hardware or a controller of your own: it compiles, its test passes, "
      "its cell runs",
      "polyarm new");
  std::string kind, name, vendor, folder;
  app.add_option("kind", kind, "hardware or controller")->required()->one_of({"hardware", "controller"});
  app.add_option("name", name, "its name: my_arm, which makes the type MyArm")->required();
  app.add_option("--vendor", vendor, "the first part of its full name, VENDOR/TYPE; NAME where not given");
  app.add_option("--folder", folder, "the folder to make; ./NAME where not given");
  app.footer(examples({"polyarm new hardware my_arm --vendor acme",
                       "polyarm new controller follow_me --folder ~/follow_me"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const Names names = names_of(kind, name, vendor);
  const fs::path where = folder.empty() ? fs::path(names.name) : fs::path(folder);
  write(where, names);
  fmt::print(
      "{} {}/{} is in {}; next:\n  cd {}\n  cmake -S . -B build {}\n  cmake --build build\n"
      "  ctest --test-dir build --output-on-failure\n  polyarm run .\n",
      kind, names.vendor, names.type, where.string(), where.string(), find_option());
  return kOk;
}

}  // namespace polyarm::apps
