"""Thresholds that decide a name or a verdict stand in one table, and each says what it is compared with, where it comes from and what it costs.

Other numbers at the top of a file belong to a method: windows, grids, steps, priors of a fit. They are listed here, so that a new one is a
question: does it decide something?
"""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DIAGNOSIS = ROOT / "src/diagnosis"
TABLE = DIAGNOSIS / "result/decisions.hpp"
NUMBER = re.compile(r"^(?:inline |static )*constexpr (?:double|float|int|std::size_t)\s+([^;(]*);", re.MULTILINE)
NAME = re.compile(r"(\w+)\s*=")

# numbers of a method, by file
METHOD = {
    "alignment/align.cpp": "filtered_rate_hz common_filter_s coarse_rate_hz",  # how filtered and fast logs are read
    "estimation/innovation_filter.cpp": "cold",
    "estimation/innovations.hpp": "disturbance_groups noise_groups",
    "estimation/latency_between_rows.cpp": "kept most_left most_off_rows exact",  # which rows are compared
    "estimation/mean_torques.cpp": "averaged_s least_sd_radps2",
    "estimation/noise_model.hpp": "slowest_disturbance_s calm_memory_s",
    "estimation/rotor_speeds.cpp": "settling_s least_hover most_limit latest_s least_white_share",
    "estimation/sensor_windows.cpp": "turn_s way_s longest_share longest_gap_s clustered",  # what a window is
    "estimation/session.cpp": "fastest_sample_s most_windows least_change slow_s",
    "estimation/shooting.cpp": "rows_per_horizon loose_prior clearly_lost own_share",
    "estimation/slow_and_fast.cpp": "least_share errors",  # what a difference is
    "estimation/slow_speeds.cpp": "slow_rows",  # of the means whose changes are compared
    "estimation/surrogates.cpp": "draws places nearest",
    "estimation/torque_trims.cpp": "steps least_share",
    "evidence/challenge.cpp": "most_looks",
    "evidence/gather_evidence.cpp": "parts_of_flight shortest_part_s",
    "evidence/judge.cpp": "intercept steepness",  # fitted, as the weights are
    "hover/hover_balance.cpp": "slow_mps slow_vertical_mps margin_s",  # what hover is
    "hover/hover_balance.hpp": "least_hover_s",
    "model/catalogue.hpp": "torque_trim_sd command_clock_sd command_smoothing_sd",  # natural sizes of nuisances
    "model/command_innovation.cpp": "lags fewest_samples memory_s ridge slower_commands",
    "model/linear_flight.hpp": "error_size state_size row_count first_force_row",
    "output/habit.cpp": "ahead_s between_starts_s checks slowest_sample_s term_count unknowns usual_size",
    "output/next_flight.cpp": "crazyflie_arm_m flight_s",
    "rollout/per_flight.cpp": "rollout_s step_share prior",
    "rollout/replay.cpp": "windows_per_task",
    "rollout/verify.cpp": "restart_s most_noises window_s",
    "selection/pendulum.cpp": "widest_swing least_damping most_damping shared own",  # bounds of the scan
    "selection/select_effects.cpp": "kept_of_each_size most_changes",
    "selection/selection.hpp": "most_effects",
    "selection/stability.cpp": "half_samples",
    "selection/swing_fit.cpp": "bin_s longest_step_s shared own correlated",
    "validation/dependence.cpp": "ridge",
    "validation/generic_bases.hpp": "near_ground",
    "validation/gust_parts.cpp": "slowest_periods fastest_radps bins_apart bins_beside",
    "validation/regimes.cpp": "thirds few not_known",
}


def numbers(path):
    return [name for match in NUMBER.finditer(path.read_text(encoding="utf-8")) for name in NAME.findall(re.sub(r"//.*", "", match[1]))]


class Decisions(unittest.TestCase):
    def test_every_entry_says_its_statistic_where_it_comes_from_and_what_it_costs(self):
        entries = re.findall(r"((?:^//.*\n)+)((?:^inline constexpr (?:[^;]|\n)*;\n)+)", TABLE.read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(sum(len(NAME.findall(values)) for _, values in entries), len(numbers(TABLE)))
        self.assertGreater(len(entries), 40)
        for comment, values in entries:
            for part in ("Statistic: ", "From: ", "Costs: "):
                self.assertIn(part, comment.replace("\n// ", " "), values)

    def test_no_other_threshold_stands_at_the_top_of_a_file(self):
        found = {}
        for path in sorted(DIAGNOSIS.rglob("*.[ch]pp")):
            room = path.relative_to(DIAGNOSIS)
            # faults of a log: each stands beside the statistic of its check
            if path == TABLE or room.parts[0] == "recording":
                continue
            if names := numbers(path):
                found[str(room)] = names
        known = {file: names.split() for file, names in METHOD.items()}
        new = {file: [n for n in names if n not in known.get(file, [])] for file, names in found.items()}
        gone = {file: [n for n in names if n not in found.get(file, [])] for file, names in known.items()}
        self.assertFalse({f: n for f, n in new.items() if n}, "a decision belongs in result/decisions.hpp, a number of a method in this list")
        self.assertFalse({f: n for f, n in gone.items() if n}, "no longer there: take it out of this list")


if __name__ == "__main__":
    unittest.main()
