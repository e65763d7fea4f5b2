#pragma once
/// The files of `templates/` at build time.
#include <span>

namespace polyarm::apps {

struct TemplateFile {
  const char* kind;  ///< "hardware" or "controller"
  const char* name;  ///< "my_device.cpp"
  const char* text;
};
std::span<const TemplateFile> template_files();

}  // namespace polyarm::apps
