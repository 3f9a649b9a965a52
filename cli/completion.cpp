#include "cli/completion.h"

#include "cli/suggest.h"

namespace partscribe::cli {
namespace {

constexpr const char* help_words = "--man --markdown --completion";
constexpr const char* shell_words = "bash zsh fish";

std::string spaced(const std::vector<std::string>& words) {
  std::string result;
  for (const auto& word : words) result += (result.empty() ? "" : " ") + word;
  return result;
}

std::string command_names(const Manual& manual) {
  std::vector<std::string> names;
  for (const auto& command : manual.commands) names.push_back(command.name);
  return spaced(names);
}

/// With a backslash before each of these characters.
std::string with_backslashes(const std::string& text, const std::string& characters) {
  std::string result;
  for (const char c : text) result += (characters.find(c) == std::string::npos ? "" : "\\") + std::string(1, c);
  return result;
}

/// Within single quotes, as bash and zsh read them.
std::string single_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "'\\''" : std::string(1, c);
  return result + "'";
}

// ---- bash ----

std::string bash_options(const std::vector<Declared>& declared) {
  std::vector<std::string> names;
  for (const auto& d : declared)
    if (d.is_option()) names.push_back(d.name);
  return spaced(names);
}

/// What may follow the options of one command; `command` is a pattern of the shell.
std::string bash_values(const std::string& command, const std::vector<Declared>& declared) {
  std::string result;
  for (const auto& d : declared) {
    if (!d.is_option() || d.takes == Declared::Takes::nothing) continue;
    result += "    " + command + "\\ " + d.name + ") ";
    if (d.takes == Declared::Takes::file) result += "takes=files ;;\n";
    if (d.takes == Declared::Takes::folder) result += "takes=folders ;;\n";
    if (d.takes_words()) result += "takes=words words='" + spaced(d.words) + "' ;;\n";
  }
  return result;
}

std::string bash_completion(const Manual& manual) {
  std::string values, options;
  for (const auto& command : manual.commands) {
    values += bash_values(command.name, command.own);
    options += "          " + command.name + ") words='" + bash_options(command.own) + "' ;;\n";
  }
  return R"(# Completion of partscribe for bash, made by 'partscribe help --completion bash'.
_partscribe() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
  local takes=files words=
  # bash takes --units=mm for three words.
  if [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD - 2]}; fi
  if [[ $word == = ]]; then word=; fi
  if ((COMP_CWORD == 1)); then before= command=; fi
  case $command\ $before in
    \ ) takes=words words=')" +
         command_names(manual) + R"( help --help --version' ;;
    help\ --completion) takes=words words=')" +
         shell_words + R"(' ;;
    help\ *) takes=words words=')" +
         command_names(manual) + " " + help_words + "' ;;\n" + values + bash_values("*", manual.shared) + R"(    *)
      if [[ $word == -* ]]; then
        takes=words
        case $command in
)" + options +
         R"(        esac
        words+=' )" +
         bash_options(manual.shared) + R"( --help'
      fi
      ;;
  esac
  case $takes in
    words) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word") ;;
    files) compopt -o filenames && mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
    folders) compopt -o filenames && mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
  esac
}
complete -F _partscribe partscribe
)";
}

// ---- zsh ----

std::string zsh_list(const std::vector<Declared>& declared, const std::string& indent) {
  std::string result;
  for (const auto& d : declared) {
    const std::string help = with_backslashes(d.help, "\\[]");
    std::string action = d.takes == Declared::Takes::file     ? "_files"
                         : d.takes == Declared::Takes::folder ? "_files -/"
                         : d.words.empty()                    ? " "
                                                              : "(" + spaced(d.words) + ")";
    std::string text = d.is_option() ? d.name + "[" + help + "]" : (d.repeated ? "*:" : ":") + d.name;
    if (d.takes != Declared::Takes::nothing) text += ":" + d.value_name + (d.is_option() ? ":" : "") + action;
    result += indent + single_quoted(text) + "\n";
  }
  return result;
}

std::string zsh_completion(const Manual& manual) {
  std::string commands, options;
  for (const auto& command : manual.commands) {
    commands += "    " + single_quoted(command.name + ":" + command.summary) + "\n";
    options += "    " + command.name + ")\n      own=(\n" + zsh_list(command.own, "        ") + "      ) ;;\n";
  }
  return R"(#compdef partscribe
# Completion of partscribe for zsh, made by 'partscribe help --completion zsh'.
_partscribe() {
  local -a commands=(
)" + commands +
         R"(    'help:explain the program, or a command'
  )
  local -a shared=(
)" + zsh_list(manual.shared, "    ") +
         R"(    '--help[explain the command]'
  )
  local -a own
  if ((CURRENT == 2)); then
    _describe command commands
    compadd -- --help --version
    return
  fi
  case $words[2] in
    help)
      if [[ $words[3] == --completion ]]; then compadd )" +
         shell_words + R"(; else _describe command commands; compadd -- )" + help_words + R"(; fi
      return ;;
)" + options +
         R"(  esac
  shift words
  ((CURRENT--))
  _arguments -s $shared $own
}
_partscribe "$@"
)";
}

// ---- fish ----

std::string fish_list(const std::vector<Declared>& declared, const std::string& condition) {
  std::string result;
  for (const auto& d : declared) {
    if (!d.is_option()) continue;
    result += "complete -c partscribe -n '" + condition + "' -l " + d.name.substr(2);
    if (d.takes == Declared::Takes::file) result += " -r -F";
    if (d.takes == Declared::Takes::folder) result += " -x -a '(__fish_complete_directories)'";
    if (d.takes_words()) result += d.words.empty() ? " -x" : " -x -a '" + spaced(d.words) + "'";
    result += " -d '" + with_backslashes(d.help, "\\'") + "'\n";
  }
  return result;
}

std::string fish_completion(const Manual& manual) {
  std::string result = R"(# Completion of partscribe for fish, made by 'partscribe help --completion fish'.
complete -c partscribe -n __fish_use_subcommand -f -l version -d 'print its version'
complete -c partscribe -l help -d 'explain the program, or a command'
complete -c partscribe -n __fish_use_subcommand -f -a help -d 'explain the program, or a command'
)";
  const std::string help = "__fish_seen_subcommand_from help";
  result += "complete -c partscribe -n '" + help + "' -f -a '" + command_names(manual) + "'\n";
  result += "complete -c partscribe -n '" + help + "' -l man -d 'print a manual page'\n";
  result += "complete -c partscribe -n '" + help + "' -l markdown -x -a '" + command_names(manual) +
            "' -d 'print what help says, in Markdown'\n";
  result += "complete -c partscribe -n '" + help + "' -l completion -x -a '" + shell_words + "'\n";
  for (const auto& command : manual.commands) {
    result += "complete -c partscribe -n __fish_use_subcommand -f -a " + command.name + " -d '" +
              with_backslashes(command.summary, "\\'") + "'\n";
    result += fish_list(command.own, "__fish_seen_subcommand_from " + command.name);
  }
  return result + fish_list(manual.shared, "__fish_seen_subcommand_from " + command_names(manual));
}

}  // namespace

Result<std::string> completion(const Manual& manual, const std::string& shell) {
  if (shell == "bash") return bash_completion(manual);
  if (shell == "zsh") return zsh_completion(manual);
  if (shell == "fish") return fish_completion(manual);
  return usage_error("--completion: expected one of bash, zsh, fish, found '" + shell + "'" +
                     did_you_mean(shell, {"bash", "zsh", "fish"}));
}

}  // namespace partscribe::cli
