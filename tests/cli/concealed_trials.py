"""Trials for `gustlab conceal` and sets for `gustlab diagnose --batch`, small enough for tests of the commands."""


def trials_toml(*names, duration_s=4.0):
    """Two flights to fit and one held out for each name; nothing is concealed in them."""
    return f"""
format = "gustlab-trials/1"
name = "t"
vehicle = "crazyflie"
controllers = ["pid"]
trajectories = ["circle"]
fit = ["circle", "circle"]
holdout = ["circle"]
seed = 1
duration_s = {duration_s}
""" + "".join(f'[[trial]]\nname = "{name}"\n' for name in names)


# of the trials "one" (with its held-out flight) and "two"
FIRST_SET = """format = "gustlab-sets/1"
[[set]]
name = "first"
fit = ["trials/one/fit_1.csv", "trials/one/fit_2.csv"]
holdout = ["trials/one/holdout_1.csv"]
"""
SECOND_SET = """[[set]]
name = "second"
fit = ["trials/two/fit_1.csv", "trials/two/fit_2.csv"]
"""
