#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "gustlab/errors.hpp"
#include "messages.hpp"
#include "report/score.hpp"

namespace gustlab {

namespace {

struct ScoreArguments {
  std::vector<std::string> places;
  std::string diagnosis = "diagnosis";
  std::string format = "md";
};

void score(const ScoreArguments& options) {
  if (options.places.size() % 2 != 0)
    throw ConfigError("score: answers without a folder (expected pairs of FILE DIR); add the folder of the trials");
  std::vector<TrialSet> sets;
  for (std::size_t i = 0; i < options.places.size(); i += 2) sets.push_back({options.places[i], options.places[i + 1]});
  const nlohmann::ordered_json result = score_trials(sets, options.diagnosis);
  if (options.format == "json") fmt::print("{}\n", config::json_text(result, 1));
  else say_on_stdout(score_markdown(result));
}

}  // namespace

void add_score(CLI::App& app) {
  const auto options = std::make_shared<ScoreArguments>();
  CLI::App* command = app.add_subcommand("score", "compares diagnoses of concealed trials with the answers");
  command
      ->add_option("FILE DIR", options->places,
                   "answers (JSON lines) and the folder of their trials, any number of pairs")
      ->required();
  command->add_option("--diagnosis", options->diagnosis, "folder of the diagnosis in each trial")
      ->capture_default_str();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "json"}))->capture_default_str();
  command->callback([options] { score(*options); });
}

}  // namespace gustlab
