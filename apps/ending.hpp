#pragma once
/// How a command that moves something ends when the system asks it to: on the path, whatever the signal is.

namespace polyarm::apps {

/// From now on every signal that can be caught stops the cell of this process on its path, and ends the run.
/// SIGINT, SIGTERM and SIGQUIT count: the second of them stops at once, the third ends the process where it
/// is. A closed terminal (SIGHUP, unless it is ignored as under nohup) and the others stop once. Output that
/// nobody reads (SIGPIPE) is an error of the write, which the run's output turns into one stop. On the wall
/// clock Ctrl-Z (SIGTSTP) holds instead of suspending a process that moves something. After SIGTERM a
/// simulated cell is ended within a second, whatever it does.
void stop_on_signals(bool wall_clock);

/// Whether what is built from now on is simulated: then SIGTERM need not wait for anything.
void set_simulated(bool simulated);

/// For signal handlers: what is written to standard output from now on goes nowhere.
void write_to_nobody() noexcept;

}  // namespace polyarm::apps
