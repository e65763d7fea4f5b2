#pragma once
/// Commands that a message tells its reader to type.
#include <string>
#include <string_view>

namespace polyarm {

/// `text` as one word of a shell's command line, in quotes if it needs them: a file of somebody else may have a name
/// that a shell would carry out.
std::string shell_word(std::string_view text);

}  // namespace polyarm
