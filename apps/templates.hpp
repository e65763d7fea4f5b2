#pragma once
/// The files of `templates/`, as they were when this program was built.
#include <span>

namespace polyarm::apps {

struct TemplateFile {
  const char* kind;  ///< "hardware" or "controller"
  const char* name;  ///< "my_device.cpp"
  const char* text;
};
std::span<const TemplateFile> template_files();

}  // namespace polyarm::apps
