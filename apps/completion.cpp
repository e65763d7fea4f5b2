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

constexpr const char* kOptions =
    "--help --json --robot --hardware --fast --cycles --seconds --description --controllers --fault "
    "--allow-contact --keep --answer --dry --urdf --xyz --rpy --quaternion --seed --joints --tcp --socket "
    "--no-socket "
    "--cell --activate --deactivate --strictness --type --file --param --rate --once --goal --count "
    "--maker --axes --reach --payload --mass --sort --names --plugins --vendor --folder --budget --move "
    "--report --real --full-speed --svg --csv --export --keep-times --blend --speed --program --joint --by "
    "--frame "
    "--for --step --continue --from --yes --stay --robots --jobs --junit --only --list --patience --follow "
    "--clear --wait --base --programs --speeds --seeds --plan --show --top --html --out --again --shard "
    "--slurm --submit";

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
  if [[ $word == -* ]]; then COMPREPLY=($(compgen -W "{1}" -- "$word")); return; fi
  COMPREPLY=($(compgen -f -- "$word"))
}}
complete -o filenames -F _polyarm polyarm
)bash",
             verb_names(), kOptions);
}
void print_zsh() {
  fmt::print(
      "# polyarm completion for zsh: put `source <(polyarm completion zsh)` into ~/.zshrc\n"
      "autoload -U +X bashcompinit && bashcompinit\n");
  print_bash();
}
void print_fish() {
  fmt::print(
      "# polyarm completion for fish: polyarm completion fish > ~/.config/fish/completions/polyarm.fish\n");
  for (const Verb& verb : verbs())
    fmt::print("complete -c polyarm -n __fish_use_subcommand -f -a {} -d '{}'\n", verb.name, verb.summary);
  fmt::print(
      "complete -c polyarm -l robot -x -a '(polyarm robots --names)'\n"
      "complete -c polyarm -l maker -x -a '(polyarm robots --names | cut -d/ -f1 | sort -u)'\n"
      "complete -c polyarm -l hardware -x -a 'declared mock mujoco'\n");
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
