#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "report/score.hpp"

namespace gustlab {

namespace {

using Json = nlohmann::ordered_json;
using Row = std::vector<std::string>;

// a Markdown table with padded columns, so that it can be read as plain text
std::string table(const Row& head, const std::vector<Row>& rows) {
  std::vector<std::size_t> width;
  for (const std::string& cell : head) width.push_back(std::max<std::size_t>(3, cell.size()));
  for (const Row& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  const auto line = [&](const Row& row) {
    std::string text = "|";
    for (std::size_t c = 0; c < row.size(); ++c)
      text += c == 0 ? fmt::format(" {:<{}} |", row[c], width[c]) : fmt::format(" {:>{}} |", row[c], width[c]);
    return text + "\n";
  };
  std::string text = line(head) + "|";
  for (std::size_t c = 0; c < head.size(); ++c)
    text += c == 0 ? fmt::format(" {:-<{}} |", "", width[c]) : fmt::format(" {:->{}}: |", "", width[c] - 1);
  text += "\n";
  for (const Row& row : rows) text += line(row);
  return text;
}

std::string percent(const Json& share) {
  return share.is_null() ? "" : fmt::format("{:.1f} %", 100.0 * share.get<double>());
}

std::string interval(const Json& rate) {
  if (rate.at("share").is_null()) return "";
  return fmt::format("{:.0f}-{:.0f} %", 100.0 * rate.at("low").get<double>(), 100.0 * rate.at("high").get<double>());
}

std::string count(const Json& rate) {
  return fmt::format("{}/{}", rate.at("k").get<std::size_t>(), rate.at("n").get<std::size_t>());
}

// 12/13, or nothing where there was no trial
std::string cell(const Json& rate) { return rate.at("n").get<std::size_t>() == 0 ? "" : count(rate); }

std::string figure(const Json& value) { return value.is_null() ? "" : fmt::format("{:.3g}", value.get<double>()); }

std::string headline(const Json& score) {
  std::vector<Row> rows;
  for (const auto& [label, rate] : score.at("headline").items())
    rows.push_back({label, count(rate), percent(rate.at("share")), interval(rate)});
  return table({"figure", "trials", "share", "95 %"}, rows);
}

std::string effects(const Json& score) {
  std::vector<Row> rows;
  for (const Json& row : score.at("effects")) {
    const Json &recall = row.at("recall"), &precision = row.at("precision");
    rows.push_back({row.at("effect").get<std::string>(), cell(recall), percent(recall.at("share")), interval(recall),
                    cell(precision), percent(precision.at("share")), interval(precision)});
  }
  return table({"effect", "named/hidden", "recall", "95 %", "right/named", "precision", "95 %"}, rows);
}

std::string power(const Json& score) {
  const Json& power = score.at("power");
  const Json& edges = power.at("strength_from");
  Row head{"strength / limit"};
  for (std::size_t b = 0; b < edges.size(); ++b)
    head.push_back(b + 1 < edges.size() ? fmt::format("{:g}-{:g}", edges[b].get<double>(), edges[b + 1].get<double>())
                                        : fmt::format(">= {:g}", edges[b].get<double>()));
  const auto row = [](const std::string& label, const Json& rates) {
    Row cells{label};
    for (const Json& rate : rates) cells.push_back(cell(rate));
    return cells;
  };
  std::vector<Row> rows{row("one effect: exact", power.at("single_exact")),
                        row("any effect: named", power.at("named"))};
  for (const auto& [effect, rates] : power.at("effects").items()) rows.push_back(row(effect, rates));
  return table(head, rows);
}

std::string parameters(const Json& score) {
  const Json& parameters = score.at("parameters");
  std::vector<Row> rows;
  for (const Json& row : parameters.at("each")) {
    const Json& coverage = row.at("coverage");
    rows.push_back({row.at("parameter").get<std::string>(), figure(row.at("median_error")),
                    percent(row.at("median_relative_error")), cell(coverage), percent(coverage.at("share")),
                    interval(coverage)});
  }
  const Json& all = parameters.at("coverage");
  rows.push_back({"all", "", "", count(all), percent(all.at("share")), interval(all)});
  return table({"parameter", "median error [SI]", "relative", "covered", "share", "95 %"}, rows);
}

std::string reliability(const Json& score) {
  const Json& reliability = score.at("reliability");
  std::vector<Row> rows;
  for (const Json& bin : reliability.at("bins")) {
    const double from = bin.at("from").get<double>();
    const Json& right = bin.at("right");
    rows.push_back({fmt::format("{:.1f}-{:.1f}", from, from + 0.1), fmt::format("{:.3f}", bin.at("said").get<double>()),
                    fmt::format("{:.3f}", right.at("share").get<double>()), count(right), interval(right)});
  }
  if (rows.empty()) return "Nothing was named or suspected: how far to trust a confidence cannot be told.\n";
  return table({"confidence", "said", "right", "names", "95 %"}, rows) +
         fmt::format("\n{} names, expected calibration error {}, Brier score {}\n",
                     reliability.at("findings").get<std::size_t>(),
                     figure(reliability.at("expected_calibration_error")), figure(reliability.at("brier")));
}

std::string closure(const Json& score) {
  std::vector<Row> rows;
  for (const Json& row : score.at("closure").at("each"))
    rows.push_back({row.at("quantity").get<std::string>(), fmt::format("{:g}", row.at("horizon_s").get<double>()),
                    fmt::format("{}", row.at("trials").get<std::size_t>()), percent(row.at("q25")),
                    percent(row.at("median")), percent(row.at("q75"))});
  return table({"quantity", "horizon [s]", "trials", "quartile", "median", "quartile"}, rows);
}

std::string confusion(const Json& score) {
  const Json& confusion = score.at("confusion");
  Row head{"concealed"};
  for (const Json& name : confusion.at("named")) head.push_back(name.get<std::string>());
  std::vector<Row> rows;
  for (const auto& [concealed, cells] : confusion.at("concealed").items()) {
    Row row{concealed};
    for (std::size_t c = 1; c < head.size(); ++c)
      row.push_back(cells.contains(head[c]) ? fmt::format("{}", cells.at(head[c]).get<int>()) : "");
    rows.push_back(row);
  }
  return table(head, rows);
}

std::string verdicts(const Json& score) {
  std::vector<Row> rows;
  for (const auto& [kind, counts] : score.at("verdicts").items())
    for (const auto& [verdict, n] : counts.items()) rows.push_back({kind, verdict, fmt::format("{}", n.get<int>())});
  return table({"kind", "verdict", "trials"}, rows);
}

std::string not_right(const Json& score) {
  const auto listed = [](const Json& entries, auto describe) {
    std::string text;
    for (const Json& entry : entries) text += (text.empty() ? "" : ", ") + describe(entry);
    return text.empty() ? std::string("nothing") : text;
  };
  std::vector<Row> rows;
  for (const Json& trial : score.at("not_right")) {
    const std::string truth = listed(trial.at("concealed"), [](const Json& entry) {
      const Json& strength = entry.at("strength_over_limit");
      return entry.at("effect").get<std::string>() +
             (strength.is_null() ? "" : fmt::format(" x{:.2g}", strength.get<double>()));
    });
    const std::string named = listed(trial.at("named"), [](const Json& entry) {
      std::string text =
          fmt::format("{} {:.2f}", entry.at("effect").get<std::string>(), entry.at("confidence").get<double>());
      if (entry.at("class").size() > 1)
        for (const Json& other : entry.at("class"))
          if (other != entry.at("effect")) text += "~" + other.get<std::string>();
      return text;
    });
    rows.push_back({trial.at("set").get<std::string>() + "/" + trial.at("trial").get<std::string>(),
                    trial.at("kind").get<std::string>(), truth, trial.at("verdict").get<std::string>(), named});
  }
  return table({"trial", "kind", "concealed (x limit)", "verdict", "named"}, rows);
}

}  // namespace

std::string score_markdown(const nlohmann::ordered_json& score) {
  std::string text =
      fmt::format("{} trials, {} without a diagnosis (each counts as a failure)\n\n",
                  score.at("trials").get<std::size_t>(), score.at("without_diagnosis").get<std::size_t>());
  const auto section = [&](const char* title, const std::string& body) {
    text += fmt::format("## {}\n\n{}\n", title, body);
  };
  section("Figures", headline(score));
  section("Each effect", effects(score));
  section("Power against strength (named/hidden)", power(score));
  section("Parameters", parameters(score));
  section("Stated confidence", reliability(score));
  section("Recoverable error closed on held-out flights", closure(score));
  section("Confusion (rows: concealed, columns: named)", confusion(score));
  section("Verdicts", verdicts(score));
  section("Not right", not_right(score));
  return text;
}

}  // namespace gustlab
