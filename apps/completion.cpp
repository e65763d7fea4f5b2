#include <fmt/format.h>

#include "apps/manual.hpp"
#include "apps/options.hpp"

namespace polyarm::apps {

namespace {
std::string verb_names() {
  std::string out;
  for (const Verb& verb : verbs()) out += (out.empty() ? "" : " ") + std::string(verb.name);
  return out;
}

/// Prints the long options of a verb; its own help is the list.
constexpr const char* kOptionsOf =
    R"sh(--help 2>/dev/null | sed -nE 's/^ +(-[[:alnum:]], *)?(--[a-z0-9-]+).*/\2/p')sh";

void print_bash() {
  fmt::print(R"bash(# polyarm completion for bash: put `source <(polyarm completion bash)` into ~/.bashrc
_polyarm() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}
  if [[ $COMP_CWORD == 1 ]]; then COMPREPLY=($(compgen -W "{0}" -- "$word")); return; fi
  if [[ $before == --robot || ${{COMP_WORDS[1]}} =~ ^(describe|fk|ik)$ && $COMP_CWORD == 2 ]]; then
    COMPREPLY=($(compgen -W "$(polyarm robots --names)" -- "$word")); return; fi
  if [[ $before == --maker ]]; then
    COMPREPLY=($(compgen -W "$(polyarm robots --names | cut -d/ -f1 | sort -u)" -- "$word")); return; fi
  if [[ $before == --sort ]]; then
    COMPREPLY=($(compgen -W "name maker axes reach payload mass -reach -payload -mass" -- "$word")); return; fi
  if [[ $before == --hardware ]]; then COMPREPLY=($(compgen -W "declared mock mujoco" -- "$word")); return; fi
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(polyarm "${{COMP_WORDS[1]}}" {1})" -- "$word")); return; fi
  COMPREPLY=($(compgen -f -- "$word"))
}}
complete -o filenames -F _polyarm polyarm
)bash",
             verb_names(), kOptionsOf);
}

void print_zsh() {
  fmt::print(
      "#compdef polyarm\n# polyarm completion for zsh: a file _polyarm in a folder of $fpath, or put\n"
      "# `source <(polyarm completion zsh)` into ~/.zshrc, after compinit\n_polyarm() {{\n  local -a "
      "polyarm_verbs=(\n");
  for (const Verb& verb : verbs()) fmt::print("    \"{}:{}\"\n", verb.name, verb.summary);
  fmt::print(R"zsh(  )
  local before=$words[CURRENT-1]
  if (( CURRENT == 2 )); then
    _describe verb polyarm_verbs
  elif [[ $before == --robot || ( $words[2] == (describe|fk|ik) && $CURRENT == 3 ) ]]; then
    compadd -- $(polyarm robots --names)
  elif [[ $before == --maker ]]; then
    compadd -- $(polyarm robots --names | cut -d/ -f1 | sort -u)
  elif [[ $before == --hardware ]]; then
    compadd -- declared mock mujoco
  elif [[ $words[CURRENT] == -* ]]; then
    compadd -- $(polyarm $words[2] {})
  else
    _files
  fi
}}
if [[ $funcstack[1] == _polyarm ]]; then _polyarm "$@"; else compdef _polyarm polyarm; fi
)zsh",
             kOptionsOf);
}

void print_fish() {
  fmt::print(
      "# polyarm completion for fish: polyarm completion fish > ~/.config/fish/completions/polyarm.fish\n");
  for (const Verb& verb : verbs())
    fmt::print("complete -c polyarm -n __fish_use_subcommand -f -a {} -d \"{}\"\n", verb.name, verb.summary);
  fmt::print(
      "complete -c polyarm -l robot -x -a '(polyarm robots --names)'\n"
      "complete -c polyarm -l maker -x -a '(polyarm robots --names | cut -d/ -f1 | sort -u)'\n"
      "complete -c polyarm -l hardware -x -a 'declared mock mujoco'\n"
      "function __polyarm_options\n  set -l words (commandline -opc)\n  polyarm $words[2] {}\nend\n"
      "complete -c polyarm -n 'not __fish_use_subcommand' -a '(__polyarm_options)'\n",
      kOptionsOf);
}
}  // namespace

int run_completion(int argc, char** argv) {
  CommandLine app("Prints shell completion, or the manual page", "polyarm completion");
  std::string shell = "bash";
  app.add_option("shell", shell, "bash, zsh or fish; man: the manual page")
      ->one_of({"bash", "zsh", "fish", "man"});
  app.footer(examples({"source <(polyarm completion bash)", "polyarm completion man | man -l -"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (shell == "man")
    fmt::print("{}", manual_page());
  else if (shell == "fish")
    print_fish();
  else if (shell == "zsh")
    print_zsh();
  else
    print_bash();
  return kOk;
}

}  // namespace polyarm::apps
