#pragma once
/// The manual page of the command, made from the table of verbs.
#include <string>

namespace polyarm::apps {

/// polyarm(1) in the language of man pages (groff_man(7)).
std::string manual_page();

}  // namespace polyarm::apps
