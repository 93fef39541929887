"""Small experiments for tests of the commands: short flights of the Crazyflie under PID."""

CIRCLE = """[trajectory.circle]
period_s = 5.0
start = "reference"
"""

GUST = """[[effect]]
type = "gust"
sigma_xy = 0.03
correlation_time = 0.5
"""

# two flights that differ in their seed, as training needs them
VARIANTS = """[[variant]]
name = "calm"
set = ["seed=1"]
[[variant]]
name = "other"
set = ["seed=2"]
"""

TUNING = """
format = "gustlab-tuning/1"
flights = 2
replicates = 1
[[controller]]
name = "pid"
parameters = [{name = "position_gain", min = 0.1, max = 4.0, start = 0.3, log = true}]
"""


def experiment_toml(*trajectories, duration_s, replicates=1, more=""):
    """The text of an experiment; `more`: tables that follow."""
    listed = ", ".join(f'"{name}"' for name in trajectories)
    return f"""format = "gustlab-experiment/1"
name = "small"
vehicle = "crazyflie"
trajectories = [{listed}]
controllers = ["pid"]
replicates = {replicates}
duration_s = {duration_s}
{more}"""


def calibration_toml(replicates, evaluations):
    """The text of a calibration of the gust on the circle, in one stage."""
    return f"""format = "gustlab-calibration/1"
table = "table2"
first_replicate = 1001
replicates = {replicates}
[[stage]]
name = "gust"
evaluations = {evaluations}
targets = [{{trajectories = ["circle"], controllers = ["pid"], metrics = ["rmse_xy_m"]}}]
parameters = [{{key = "effect.gust.sigma_xy", min = 0.015, start = 0.025, max = 0.05, log = true, unit = "N"}}]
"""
