#include "apps/options.hpp"

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

description::Catalogue open_catalogue() {
  return description::Catalogue(description::default_catalogue_folders());
}

}  // namespace polyarm::apps
