#include "apps/options.hpp"

#include "polyarm/plugins/plugins.hpp"

namespace polyarm::apps {

std::optional<int> parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? kOk : kUsage;
  }
}

std::string examples(std::initializer_list<const char*> lines) {
  std::string out = "Examples:\n";
  for (const char* line : lines) out += std::string("  ") + line + "\n";
  return out;
}

CLI::Validator hardware_name() {
  return {[](const std::string& name) -> std::string {
            for (const char* known : {"declared", "mock", "mujoco"})
              if (name == known) return {};
            return name.find('/') != std::string::npos
                       ? ""
                       : "'" + name + "' is not declared, mock, mujoco or VENDOR/TYPE";
          },
          "NAME"};
}

void add_plugin_option(CLI::App& app, std::vector<std::string>& folders) {
  app.add_option("--plugins", folders, "folder with plugins; may be repeated")->check(CLI::ExistingDirectory);
}

void load_plugins(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) plugins::load_folder(folder);
}

description::Catalogue open_catalogue() {
  return description::Catalogue(description::default_catalogue_folders());
}

}  // namespace polyarm::apps
