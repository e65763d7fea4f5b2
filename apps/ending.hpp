#pragma once
/// How a command that moves something ends on a signal: always on the path.

namespace polyarm::apps {

/// From now on every signal that can be caught stops this process's cell on its path and ends the run.
/// SIGINT, SIGTERM and SIGQUIT are counted: the second stops at once, the third ends the process immediately.
/// A closed terminal (SIGHUP, unless ignored as under nohup) and other signals stop once. Output that nobody
/// reads (SIGPIPE) is a write error, which the run's output turns into one stop. On the wall clock, Ctrl-Z
/// (SIGTSTP) holds the robots instead of suspending the process. After SIGTERM a simulated cell ends within a
/// second in any case.
void stop_on_signals(bool wall_clock);

/// Call before a cell is built: true if it is simulated, so the end after SIGTERM does not wait for anything.
void set_simulated(bool simulated);

/// For signal handlers: discards everything written to standard output from now on.
void write_to_nowhere() noexcept;

}  // namespace polyarm::apps
