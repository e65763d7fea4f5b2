#pragma once
/// Priorities of the lines that a cell prints into the journal of systemd.
#include <string>
#include <string_view>

namespace polyarm::apps {

/// The numbers of syslog; `journalctl --priority` selects by them.
enum class Priority { error = 3, warning = 4, notice = 5, info = 6, debug = 7 };

/// True if `descriptor` is the stream to the journal that systemd opened: `JOURNAL_STREAM` names its device
/// and inode. A pipe or file that a user put in its place is not, although the variable is still set.
bool leads_to_journal(int descriptor);

/// The text with `<N>` at the start of each line, as the journal reads it (man 3 sd-daemon). The last line
/// may lack its line feed.
std::string for_journal(std::string_view text, Priority priority);

}  // namespace polyarm::apps
