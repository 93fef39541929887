// The command line described for shells and as a man page, from the commands themselves.
#include <fmt/format.h>

#include <memory>
#include <regex>

#include "commands.hpp"
#include "gustlab/build_info.hpp"

namespace gustlab {

namespace {

struct OptionWords {
  std::vector<std::string> names;  // --out, -j
  std::string says;
  std::vector<std::string> choices;
  bool takes_value = false;
  bool positional = false;
};

// A command as it is typed after gustlab: "sweep", "vehicle new".
struct CommandWords {
  std::string words, says;
  std::vector<OptionWords> options;
};

// CLI11 writes the choices of an option into its type, as {a,b,c}
std::vector<std::string> choices_of(const std::string& type) {
  std::smatch found;
  std::vector<std::string> choices;
  if (!std::regex_search(type, found, std::regex(R"(\{([^}]*)\})"))) return choices;
  static const std::regex item("[^,]+");
  const std::string all = found[1].str();
  for (std::sregex_token_iterator word(all.begin(), all.end(), item), end; word != end; ++word)
    choices.push_back(*word);
  return choices;
}

// the options in a help text of Python's argparse: "  -q, --quiet  errors only", or what it says in the next line
std::vector<OptionWords> options_in(const std::string& help) {
  static const std::regex line(R"((?:^|\n)  (-[^\n]*?)(?:\n? {2,}([^\n]+))?(?=\n))"), name("(--?[a-z][a-z-]*)");
  std::vector<OptionWords> options;
  for (std::sregex_iterator found(help.begin(), help.end(), line), end; found != end; ++found) {
    const std::string words = (*found)[1];
    OptionWords one{{}, (*found)[2], choices_of(words)};
    for (std::sregex_iterator each(words.begin(), words.end(), name); each != end; ++each)
      one.names.push_back((*each)[1]);
    one.takes_value = words.find_last_of(' ') != std::string::npos && words[words.find_last_of(' ') + 1] != '-';
    options.push_back(std::move(one));
  }
  return options;
}

void collect(const CLI::App& app, const std::string& words, std::vector<CommandWords>& found) {
  CommandWords command{words, app.get_description(), {}};
  for (const CLI::Option* option : app.get_options()) {
    OptionWords one{{},
                    option->get_description(),
                    choices_of(option->get_type_name()),
                    option->get_items_expected_max() > 0,
                    option->get_positional()};
    for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
    if (one.positional) one.names = {option->get_name()};
    command.options.push_back(std::move(one));
  }
  if (app.get_prefix_command()) command.options = options_in(help_of_script(app.get_name()));
  found.push_back(std::move(command));
  for (const CLI::App* sub : app.get_subcommands(nullptr))
    collect(*sub, words.empty() ? sub->get_name() : words + " " + sub->get_name(), found);
}

// every command, the program itself first, under the empty name
std::vector<CommandWords> commands_of(const CLI::App& app) {
  std::vector<CommandWords> found;
  collect(app, "", found);
  return found;
}

std::string first_word(const std::string& words) { return words.substr(0, words.find(' ')); }
bool is_below(const CommandWords& command, const CommandWords& parent) {
  const std::string start = parent.words.empty() ? "" : parent.words + " ";
  return command.words.size() > start.size() && command.words.starts_with(start) &&
         command.words.find(' ', start.size()) == std::string::npos;
}
std::string last_word(const std::string& words) { return words.substr(words.find_last_of(' ') + 1); }

// an explanation in brackets, as _arguments of zsh takes it
std::string in_brackets(const std::string& text) {
  return '[' + std::regex_replace(text, std::regex(R"([\[\]\\])"), R"(\$&)") + ']';
}

// with apostrophes that no shell takes for a quote
std::string typographic(const std::string& text) { return std::regex_replace(text, std::regex("'"), "’"); }

// words that may come after a command: the commands below it and its options
std::string words_after(const CommandWords& command, const std::vector<CommandWords>& all) {
  std::vector<std::string> words;
  for (const CommandWords& below : all)
    if (is_below(below, command)) words.push_back(last_word(below.words));
  for (const OptionWords& option : command.options) {
    if (option.positional) words.insert(words.end(), option.choices.begin(), option.choices.end());
    else words.insert(words.end(), option.names.begin(), option.names.end());
  }
  return fmt::format("{}", fmt::join(words, " "));
}

std::string bash_completion(const std::vector<CommandWords>& all) {
  std::string text =
      "# bash completion of gustlab, made by `gustlab completion bash`\n_gustlab() {\n  local "
      "word=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD-1]}\" "
      "command=\"\" next i\n  for ((i = 1; i < COMP_CWORD; i++)); do\n    next=\"$command${command:+ "
      "}${COMP_WORDS[i]}\"\n    case \"$next\" in\n      ";
  std::vector<std::string> quoted;
  for (const CommandWords& command : all)
    if (!command.words.empty()) quoted.push_back('"' + command.words + '"');
  text += fmt::format(
      "{}) command=\"$next\" ;;\n      *) break ;;\n    esac\n  done\n  COMPREPLY=()\n  case \"$command:$before\" in\n",
      fmt::join(quoted, " | "));
  for (const CommandWords& command : all)
    for (const OptionWords& option : command.options)
      for (const std::string& name : option.names)
        if (option.takes_value && !option.positional)
          text += fmt::format("    \"{}:{}\") {}return ;;\n", command.words, name,
                              option.choices.empty() ? ""
                                                     : fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$word\")); ",
                                                                   fmt::join(option.choices, " ")));
  text += "  esac\n  case \"$command\" in\n";
  for (const CommandWords& command : all)
    text += fmt::format("    \"{}\") COMPREPLY=($(compgen -W \"{}\" -- \"$word\")) ;;\n", command.words,
                        words_after(command, all));
  return text + "  esac\n}\ncomplete -o default -F _gustlab gustlab\n";
}

std::string zsh_completion(const std::vector<CommandWords>& all) {
  std::string text = "#compdef gustlab\n# zsh completion of gustlab, made by `gustlab completion zsh`\n";
  // one function per command; a function with commands below it hands over to theirs
  for (const CommandWords& command : all) {
    const auto function = [](const std::string& words) {
      return std::regex_replace("_gustlab_" + words, std::regex(" "), "_");
    };
    text += fmt::format("{}() {{\n", function(command.words));
    std::string below;
    for (const CommandWords& other : all)
      if (is_below(other, command)) below += fmt::format(" '{}:{}'", last_word(other.words), typographic(other.says));
    if (!below.empty()) {
      text += fmt::format(
          "  local -a below\n  below=({})\n  if (( CURRENT == 2 )); then _describe command below; return; fi\n"
          "  local function=\"{}${{words[2]}}\"\n  (( $+functions[$function] )) || return 1\n  shift words; (( "
          "CURRENT-- ))\n  $function\n}}\n",
          below.substr(1), command.words.empty() ? "_gustlab_" : function(command.words) + "_");
      continue;
    }
    text += "  _arguments";
    std::string words = "file:_files";
    for (const OptionWords& option : command.options) {
      const std::string values =
          option.choices.empty() ? "_files" : fmt::format("({})", fmt::join(option.choices, " "));
      if (option.positional && !option.choices.empty()) words = "word:" + values;
      if (option.positional) continue;
      for (const std::string& name : option.names)
        text += fmt::format(" \\\n    '*{}{}{}'", name, in_brackets(typographic(option.says)),
                            option.takes_value ? ":value:" + values : "");
    }
    text += " \\\n    '*:" + words + "'\n}\n";
  }
  return text + "_gustlab_ \"$@\"\n";
}

std::string fish_completion(const std::vector<CommandWords>& all) {
  std::string text = "# fish completion of gustlab, made by `gustlab completion fish`\n";
  for (const CommandWords& command : all) {
    std::string seen =
        command.words.empty() ? "__fish_use_subcommand" : "__fish_seen_subcommand_from " + first_word(command.words);
    if (command.words.find(' ') != std::string::npos)
      seen += "; and __fish_seen_subcommand_from " + last_word(command.words);
    for (const CommandWords& below : all)
      if (is_below(below, command))
        text += fmt::format("complete -c gustlab -n '{}' -f -a {} -d '{}'\n", seen, last_word(below.words),
                            typographic(below.says));
    for (const OptionWords& option : command.options) {
      if (option.positional && !option.choices.empty())
        text += fmt::format("complete -c gustlab -n '{}' -f -a '{}'\n", seen, fmt::join(option.choices, " "));
      if (option.positional) continue;
      text += fmt::format("complete -c gustlab -n '{}'", seen);
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (option.takes_value)
        text += option.choices.empty() ? " -r" : fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
      text += fmt::format(" -d '{}'\n", typographic(option.says));
    }
  }
  return text;
}

// text that troff takes as it is
std::string troff(const std::string& text) {
  std::string result = std::regex_replace(text, std::regex(R"(\\)"), R"(\e)");
  result = std::regex_replace(result, std::regex("-"), R"(\-)");
  return result.starts_with('.') || result.starts_with('\'') ? R"(\&)" + result : result;
}

std::string man_page(const std::vector<CommandWords>& all) {
  std::string text = fmt::format(
      ".TH GUSTLAB 1 \"\" \"gustlab {}\" \"User Commands\"\n.SH NAME\ngustlab \\- {}\n.SH SYNOPSIS\n.B "
      "gustlab\nCOMMAND [OPTION...]\n",
      build_info().version, troff(all.front().says));
  text +=
      ".SH DESCRIPTION\nData goes to standard output, messages to standard error. A crashed vehicle is a result, not "
      "an error.\n.SH COMMANDS\n";
  for (const CommandWords& command : all) {
    if (command.words.empty()) continue;
    text += fmt::format(".SS gustlab {}\n{}\n", troff(command.words), troff(command.says));
    for (const OptionWords& option : command.options) {
      text +=
          fmt::format(".TP\n.B {}\n{}{}\n", troff(fmt::format("{}", fmt::join(option.names, ", "))), troff(option.says),
                      option.choices.empty() ? "" : troff(fmt::format(" ({})", fmt::join(option.choices, " | "))));
    }
  }
  return text +
         ".SH EXIT STATUS\n0 fine; 1 a gate or check failed; 2 usage or configuration; 3 input data; 4 internal or "
         "input/output; 130 interrupted.\n"
         ".SH ENVIRONMENT\n.TP\n.B GUSTLAB_HOME\nfolder that holds models/, configs/ and experiments/, looked at "
         "first\n.TP\n.B NO_COLOR\nno colours in messages\n";
}

}  // namespace

void add_completion(CLI::App& app) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "prints what makes a shell complete gustlab's commands and options");
  command->add_option("SHELL", *shell)->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell, &app] {
    const std::vector<CommandWords> all = commands_of(app);
    fmt::print("{}", *shell == "bash"  ? bash_completion(all)
                     : *shell == "zsh" ? zsh_completion(all)
                                       : fish_completion(all));
  });
  app.add_subcommand("man", "prints the man page (gustlab man | man -l -)")->callback([&app] {
    fmt::print("{}", man_page(commands_of(app)));
  });
}

}  // namespace gustlab
