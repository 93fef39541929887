"""`gustlab vehicle`: a vehicle from a few numbers, checked in a simulated hover, and one clear message for each wrong input."""

import json
import math
import os
import re
import subprocess
import tomllib
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
NEW = ["vehicle", "new", "--mass", "1.2kg", "--arm", "0.25m", "--prop", "10in", "--thrust-to-weight", "2.1"]
BODY = """<mujoco><worldbody><body><freejoint/><inertial pos="0 0 0" mass="1.2" diaginertia="0.018 0.018 0.03"/>
<geom type="box" size="0.1 0.1 0.03"/>
<site name="a" pos="0.17 -0.17 0"/><site name="b" pos="-0.17 0.17 0"/><site name="c" pos="0.17 0.17 0"/><site name="d" pos="-0.17 -0.17 0"/>
</body></worldbody></mujoco>"""
# f h^2 + (1 - f) h = 1 / 2.1 with the usual curve f = 0.65
HOVER = (-0.35 + math.sqrt(0.35**2 + 4 * 0.65 / 2.1)) / 1.3
ROTORS = "".join(f'[[rotor]]\nsite = "{site}"\ndirection = "{direction}"\n' for site, direction in zip("abcd", ("ccw", "ccw", "cw", "cw")))
LEAST = f'format = "gustlab-vehicle/1"\nmjcf = "body.xml"\n{ROTORS}[thrust]\n'


def gustlab(*arguments, folder):
    return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=False)


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, text, body=BODY):
        (self.folder / "body.xml").write_text(body, encoding="utf-8")
        (self.folder / "vehicle.toml").write_text(text, encoding="utf-8")

    def ok(self, *arguments):
        done = gustlab(*arguments, folder=self.folder)
        # what takes half a minute, as on a slow machine, says what it does
        said = [line for line in done.stderr.splitlines() if not line.endswith(" so far")]
        self.assertEqual((done.returncode, said), (0, []), done.stdout)
        return done.stdout

    def new(self, *arguments):
        self.assertEqual(self.ok(*arguments, "--out", "mine"), "mine/vehicle.toml\n")
        return tomllib.loads((self.folder / "mine" / "vehicle.toml").read_text(encoding="utf-8"))

    def check(self, vehicle):
        return json.loads(self.ok("vehicle", "check", vehicle, "--format", "json"))


class NewVehicle(InFolder):
    def test_what_was_given_comes_back_from_the_simulated_hover(self):
        vehicle = self.new(*NEW)
        self.assertAlmostEqual(vehicle["thrust"]["radius_m"], 0.127)
        self.assertAlmostEqual(vehicle["thrust"]["hover"], HOVER, places=3)
        said = self.check("mine/vehicle.toml")
        self.assertEqual(self.check("mine"), said)   # the folder stands for its file
        self.assertEqual((said["mass_kg"], said["contradictions"], said["hover"]["outcome"]), (1.2, [], "completed"))
        self.assertAlmostEqual(said["thrust_to_weight"], 2.1, places=2)
        for rotor in said["hover"]["trim"]:
            self.assertAlmostEqual(rotor["throttle"], HOVER, places=3)

    def test_effects_of_the_file_count(self):
        self.write(LEAST + "coefficient = 1e-5\nmax_speed_radps = 900\n")
        plain = self.check("vehicle.toml")
        self.write(LEAST + "coefficient = 1e-5\nmax_speed_radps = 900\n"
                   '[[effect]]\ntype = "mass"\ndelta = 0.25\n[[effect]]\ntype = "thrust_scale"\ndelta = 0.1\n[[effect]]\ntype = "saturation"\nmax_speed = 810\n')
        said = self.check("vehicle.toml")
        self.assertAlmostEqual(said["mass_kg"], plain["mass_kg"] * 1.25)
        self.assertAlmostEqual(said["thrust_to_weight"] * said["weight_N"], plain["thrust_to_weight"] * plain["weight_N"] * 1.1 * 0.81)

    def test_a_large_error_of_the_hover_has_no_exponent(self):
        self.write(LEAST + 'coefficient = 1e-5\nmax_speed_radps = 900\n[[effect]]\ntype = "thrust_scale"\ndelta = -0.45\n')
        error_mm = 1e3 * self.check("vehicle.toml")["hover"]["error_m"]
        self.assertGreater(error_mm, 99.5)
        self.assertIn(f"{float(f'{error_mm:.2g}'):.0f} mm from the reference", self.ok("vehicle", "check", "vehicle.toml"))

    def test_every_number_says_where_it_comes_from(self):
        self.new(*NEW)
        lines = (self.folder / "mine" / "vehicle.toml").read_text(encoding="utf-8").splitlines()
        for key in ("hover", "radius_m", "torque_ratio", "throttle_curve"):
            at = next(i for i, line in enumerate(lines) if line.startswith(key))
            self.assertRegex(lines[at - 1], "^# .*(given|estimated|assumed|from)", key)
        self.assertIn("inertia: estimated", (self.folder / "mine" / "mine.xml").read_text(encoding="utf-8"))

    def test_every_layout_hovers(self):
        for layout in ("x", "+", "x-betaflight", "x-crazyflie", "hexa", "hexa+", "octo", "octo+"):
            out = "v" + layout.replace("+", "p").replace("-", "_")
            self.ok("vehicle", "new", "--mass", "2 kg", "--arm", "30cm", "--hover", "0.5", "--layout", layout, "--out", out)
            said = self.check(f"{out}/vehicle.toml")
            self.assertEqual((said["hover"]["outcome"], said["contradictions"]), ("completed", []), layout)

    def test_motors_are_where_the_autopilots_have_them(self):
        vehicle = self.new(*NEW)
        self.assertEqual([rotor["direction"] for rotor in vehicle["rotor"]], ["ccw", "ccw", "cw", "cw"])
        body = (self.folder / "mine" / "mine.xml").read_text(encoding="utf-8")
        # front right, back left, front left, back right; x forward, y left
        for i, place in enumerate(("0.1768 -0.1768 0", "-0.1768 0.1768 0", "0.1768 0.1768 0", "-0.1768 -0.1768 0"), 1):
            self.assertIn(f'name="rotor{i}" pos="{place}"', body)

    def test_px4_logs_tell_places_hover_and_curve(self):
        folder = os.environ.get("GUSTLAB_FLIGHTS")
        if not folder:
            self.skipTest("GUSTLAB_FLIGHTS is not set")
        logs = Path(folder) / "logs"
        vehicle = self.new("vehicle", "new", "--mass", "2kg", "--from-px4", str(logs / "px4_climb_28s.ulg"))
        self.assertAlmostEqual(vehicle["thrust"]["hover"], 0.4804)
        self.assertIn('pos="0.2164 -0.2159 0"', (self.folder / "mine" / "mine.xml").read_text(encoding="utf-8"))
        quad = str(logs / "px4_quad_55s.ulg")
        done = gustlab("vehicle", "new", "--mass", "2kg", "--hover", "0.4", "--from-px4", quad, folder=self.folder)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("--arm is missing", done.stderr)
        self.ok("vehicle", "new", "--mass", "2kg", "--hover", "0.4", "--arm", "0.3m", "--from-px4", quad, "--out", "other")
        self.assertEqual(tomllib.loads((self.folder / "other" / "vehicle.toml").read_text(encoding="utf-8"))["actuator"]["throttle_curve"], 0.0)
        done = gustlab("vehicle", "new", "--mass", "2kg", "--from-px4", str(logs / "px4_fixed_wing_6s.ulg"), folder=self.folder)
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertIn("not of a multicopter", done.stderr)

    def test_ardupilot_logs_tell_the_same(self):
        folder = os.environ.get("GUSTLAB_FLIGHTS")
        if not folder:
            self.skipTest("GUSTLAB_FLIGHTS is not set")
        logs = Path(folder) / "logs"
        vehicle = self.new("vehicle", "new", "--mass", "2kg", "--arm", "30cm", "--from-log", str(logs / "ardupilot_rtl_51s.bin"))
        # the autopilot's own estimate is MOT_THST_HOVER 0.2096, before it divides by the density of the air, 0.97
        self.assertAlmostEqual(vehicle["thrust"]["hover"], 0.2096 / 0.97, delta=0.004)
        self.assertEqual(vehicle["actuator"]["throttle_curve"], 0)
        self.assertEqual([rotor["direction"] for rotor in vehicle["rotor"]], ["ccw", "ccw", "cw", "cw"])

    def test_the_same_numbers_give_the_same_bytes(self):
        self.new(*NEW)
        first = [path.read_bytes() for path in sorted((self.folder / "mine").iterdir())]
        for path in (self.folder / "mine").iterdir():
            path.unlink()
        self.new(*NEW)
        self.assertEqual(first, [path.read_bytes() for path in sorted((self.folder / "mine").iterdir())])


class CheckVehicle(InFolder):
    def test_what_is_left_out_is_said_with_its_effects(self):
        self.write(LEAST + "hover = 0.5\n")
        unknown = "\n".join(self.check("vehicle.toml")["unknown"])
        for text in ("no rotor radius ([thrust] radius_m): ground_effect, ceiling_effect, wall_effect cannot", "yaw_torque_ratio", "rotor_inertia"):
            self.assertIn(text, unknown)

    def test_contradictions_are_found(self):
        good = LEAST + "coefficient = 1.5e-5\ntorque_ratio = 0.018\nradius_m = 0.127\nmax_speed_radps = 800\n"
        self.write(good)
        self.assertEqual(self.check("vehicle.toml")["contradictions"], [])
        cases = {
            "same way": (good.replace('"cw"', '"ccw"'), BODY, "yaws in hover"),
            "overlap": (good.replace("0.127", "0.2"), BODY, "overlap"),
            "torque in mm": (good.replace("0.018", "18"), BODY, "torque ratio"),
            "coefficient per rpm": (good.replace("1.5e-5", "1.5e-7").replace("800", "8000"), BODY, "thrust coefficient"),
            "inertia in g m2": (good, BODY.replace("0.018 0.018 0.03", "18 18 30"), "moment of inertia"),
            "rotor upside down": (good, BODY.replace('<site name="a"', '<site euler="180 0 0" name="a"'), "does not push upwards"),
            "centre of mass": (good, BODY.replace('pos="0 0 0"', 'pos="0.15 0 0"'), "centre of mass"),
            "map that cannot fly": (good + "[actuator]\nthrottle_thrust = [0, 1, 1]\n", BODY, "does not fly"),
        }
        for name, (text, body, words) in cases.items():
            self.write(text, body)
            done = gustlab("vehicle", "check", "vehicle.toml", folder=self.folder)
            self.assertEqual((done.returncode, done.stderr), (1, ""), name)
            self.assertRegex(done.stdout, f"contradiction .*{words}", name)

    def test_shipped_vehicles_hover(self):
        for name in ("crazyflie", "crazyflie_21", "crazyflie_real", "iris"):
            done = gustlab("vehicle", "check", name, "--format", "json", folder=self.folder)
            self.assertEqual(json.loads(done.stdout)["hover"]["outcome"], "completed", name)


class FitOnAThrustStand(InFolder):
    """Rows of a rotor with known constants: k = 1.5e-5 N/(rad/s)^2, 0.018 m, f = (0.2 + u + 6 u^2) (V / V0)^1.6."""

    def stand(self, columns, rows=60):
        lines = [",".join(columns)]
        for i in range(rows):
            u, volts = 0.1 + 0.85 * (i % 12) / 11, 16.4 - 2.0 * i / rows
            thrust = (0.2 + u + 6 * u * u) * (volts / 15.4) ** 1.6
            speed = math.sqrt(thrust / 1.5e-5)
            values = {"throttle": u, "pulse_us": 1000 + 1000 * u, "voltage_V": volts, "thrust_N": thrust, "thrust_gf": thrust / 9.80665e-3,
                      "speed_radps": speed, "speed_rpm": speed * 30 / math.pi, "torque_Nm": 0.018 * thrust}
            lines.append(",".join(f"{values[column]:.9g}" for column in columns))
        (self.folder / "stand.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    def fit(self):
        said = self.ok("vehicle", "fit", "--thrust-stand", "stand.csv", "--vehicle", "vehicle.toml", "--out", "fitted")
        vehicle = tomllib.loads((self.folder / "fitted" / "vehicle.toml").read_text(encoding="utf-8"))
        return said, vehicle

    def test_constants_come_back_in_any_unit(self):
        for columns in (("throttle", "thrust_N", "speed_radps", "torque_Nm", "voltage_V"), ("pulse_us", "thrust_gf", "speed_rpm", "torque_Nm", "voltage_V")):
            self.write(LEAST + "hover = 0.5\n\n[actuator]\nthrottle_curve = 0.4\n")
            self.stand(columns)
            said, vehicle = self.fit()
            self.assertNotIn("stays unknown", said)
            self.assertAlmostEqual(vehicle["thrust"]["coefficient"], 1.5e-5, delta=1e-8)
            self.assertAlmostEqual(vehicle["thrust"]["torque_ratio"], 0.018, places=5)
            self.assertNotIn("hover", vehicle["thrust"])
            self.assertAlmostEqual(vehicle["thrust"]["max_speed_radps"] ** 2 * 1.5e-5 * (15.4 / vehicle["thrust"]["nominal_voltage_V"]) ** 1.6, 7.2, delta=0.05)
            self.assertEqual(vehicle["effect"][0]["type"], "battery_sag")
            self.assertAlmostEqual(vehicle["effect"][0]["exponent"], 1.6, places=2)
            for got, wanted in zip(vehicle["actuator"]["throttle_thrust"], (0.2, 1.0, 6.0)):
                self.assertAlmostEqual(got * (15.4 / vehicle["thrust"]["nominal_voltage_V"]) ** 1.6, wanted, delta=0.02)
            for path in (self.folder / "fitted").iterdir():
                path.unlink()

    def test_the_fastest_speed_of_the_file_stays(self):
        self.write(LEAST + "coefficient = 1e-5\nmax_speed_radps = 800\n")
        self.stand(("throttle", "thrust_N", "speed_radps"))
        self.assertEqual(self.fit()[1]["thrust"]["max_speed_radps"], 800)

    def test_what_was_not_measured_stays_unknown_and_as_it_was(self):
        self.write(LEAST + "# from a data sheet\ntorque_ratio = 0.02\n# a guess\ncoefficient = 1e-5\n")
        self.stand(("thrust_N", "speed_radps"))
        said, vehicle = self.fit()
        for words in ("torque ratio", "map from the input"):
            self.assertRegex(said, f"stays unknown: the {words}")
        self.assertEqual(vehicle["thrust"]["torque_ratio"], 0.02)
        text = (self.folder / "fitted" / "vehicle.toml").read_text(encoding="utf-8")
        self.assertIn("# from a data sheet\ntorque_ratio", text)
        self.assertNotIn("a guess", text)
        self.assertIn("thrust stand, 60 rows of stand.csv", text)


    def test_a_vehicle_goes_with_all_its_files(self):
        self.stand(("throttle", "thrust_N", "speed_radps"))
        self.write(LEAST.replace("body.xml", "body/body.xml") + "coefficient = 1e-5\nmax_speed_radps = 800\n")
        (self.folder / "body").mkdir()
        (self.folder / "body" / "plate.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", encoding="utf-8")
        (self.folder / "body" / "body.xml").write_text(BODY.replace("<worldbody>", '<asset><mesh name="p" file="plate.obj"/></asset><worldbody>').replace(
            "</body>", '<geom type="mesh" mesh="p" mass="0" contype="0" conaffinity="0"/></body>'), encoding="utf-8")
        self.fit()
        self.assertEqual(sorted(str(path.relative_to(self.folder / "fitted")) for path in (self.folder / "fitted").rglob("*.*")),
                         ["body/body.xml", "body/plate.obj", "vehicle.toml"])
        self.ok("vehicle", "check", "fitted")


class FitOnFlights(InFolder):
    def fit(self, truth, vehicle="", change=lambda log: None):
        """(what is printed, the fitted vehicle) of flights of a vehicle that differs from its file by these effects; change: of their logs"""
        self.write(LEAST + "coefficient = 1.5e-5\nmax_speed_radps = 800\n" + vehicle)
        effects = "".join("[[effect]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in effect.items()) for effect in truth)
        (self.folder / "e.toml").write_text(
            'format = "gustlab-experiment/1"\nname = "e"\nvehicle = "vehicle.toml"\ntrajectories = ["multisine", "lemniscate"]\ncontrollers = ["geometric"]\n'
            "duration_s = 12\n[trajectory.multisine]\nyaw_amplitude_rad = 0.5\n" + effects
            + '[[effect]]\ntype = "measurement_noise"\nposition_sd = 0.001\nattitude_sd = 0.001\nrate_sd = 0.005\naccelerometer_sd = 0.05\n', encoding="utf-8")
        for trajectory, out in (("multisine", "a"), ("lemniscate", "b")):
            done = gustlab("run", "e.toml", "--trajectory", trajectory, "--controller", "geometric", "--out", out, folder=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            change(self.folder / out / "flight.csv")
        done = gustlab("vehicle", "fit", "a/flight.csv", "--holdout", "b/flight.csv", "--vehicle", "vehicle.toml", "--out", "fitted", folder=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout, tomllib.loads((self.folder / "fitted" / "vehicle.toml").read_text(encoding="utf-8"))

    def test_an_imported_vehicle_gets_its_mass_or_thrust_lag_and_torque_ratio(self):
        said, vehicle = self.fit([{"type": "thrust_scale", "delta": -0.1}, {"type": "motor_lag", "time_constant": 0.05},
                                  {"type": "yaw_torque_ratio", "delta": 0.5}], "radius_m = 0.127\n")
        self.assertAlmostEqual(vehicle["thrust"]["coefficient"], 0.9 * 1.5e-5, delta=0.03e-5)
        # estimated from the propeller: 0.07 diameters
        self.assertAlmostEqual(vehicle["thrust"]["torque_ratio"], 1.5 * 0.07 * 0.254, delta=0.1 * 1.5 * 0.07 * 0.254)
        lag = next(effect for effect in vehicle["effect"] if effect["type"] == "motor_lag")
        self.assertAlmostEqual(lag["time_constant"], 0.05, delta=0.005)
        self.assertIn("ceiling_effect       stays unknown: no ceiling height", said)

    def test_inertia_and_the_curve_of_thrust_come_back_and_what_the_file_lacks_stays_unknown(self):
        said, vehicle = self.fit([{"type": "inertia", "delta_x": 0.3, "delta_y": 0.2, "delta_z": -0.3}, {"type": "thrust_curve", "curvature": -0.15},
                                  {"type": "steady_wind", "x": 2.0, "y": 0.0}, {"type": "rotor_drag", "at_hover": 0.3}])
        found = {effect["type"]: effect for effect in vehicle["effect"]}
        for axis, wanted in (("x", 0.3), ("y", 0.2), ("z", -0.3)):
            self.assertAlmostEqual(found["inertia"][f"delta_{axis}"], wanted, delta=0.03)
        self.assertAlmostEqual(found["thrust_curve"]["curvature"], -0.15, delta=0.015)
        self.assertAlmostEqual(found["rotor_drag"]["at_hover"], 0.3, delta=0.03)
        self.assertEqual(vehicle["thrust"]["coefficient"], 1.5e-5)
        # the wind is of one day: it is taken into account, and is no constant of the vehicle
        self.assertNotIn("steady_wind", found)
        self.assertIn("after, with what is not a constant of the vehicle", said)
        self.assertIn("steady_wind          not written: it is of a flight", said)
        self.assertIn("yaw_torque_ratio     stays unknown: the vehicle file has no torque ratio", said)
        self.assertIn("ground_effect        stays unknown: no ground height", said)
        # what is written flies, with a number of digits that a reader can take in
        self.assertNotRegex((self.folder / "fitted" / "vehicle.toml").read_text(encoding="utf-8"), r"\d\.\d{8}")
        self.ok("vehicle", "check", "fitted/vehicle.toml")

    @pytest.mark.slow
    def test_a_delay_within_its_tolerance_is_none_and_a_flight_held_out_is_not_counted(self):
        said, vehicle = self.fit([{"type": "thrust_scale", "delta": -0.1}, {"type": "actuation_delay", "delay": 0.001}])
        self.assertNotIn("actuation_delay", [effect["type"] for effect in vehicle.get("effect", [])])
        self.assertRegex(said, r"actuation_delay      not written: 0\.00\d+ ± \S+ s is within its tolerance")
        self.ok("vehicle", "fit", "a/flight.csv", "b/flight.csv", "--vehicle", "vehicle.toml", "--out", "both")
        # flights of two vehicles have no constants in common, unless they are said to be of one
        other = self.folder / "b" / "flight.meta.toml"
        other.write_text(re.sub('(?m)^vehicle = .*$', 'vehicle = "crazyflie"', other.read_text(encoding="utf-8")), encoding="utf-8")
        done = gustlab("vehicle", "fit", "a/flight.csv", "b/flight.csv", "--out", "two", folder=self.folder)
        self.assertEqual((done.returncode, done.stdout, (self.folder / "two").exists()), (3, "", False), done.stderr)
        self.assertRegex(done.stderr, "b/flight.csv.*vehicle")
        for folder in ("fitted", "both"):
            text = (self.folder / folder / "vehicle.toml").read_text(encoding="utf-8")
            self.assertIn("fitted on 1 flight by gustlab vehicle fit", text)

    def test_how_thrust_falls_with_the_battery_comes_back(self):
        def with_voltage(log):
            """the voltage whose power 1.5 is the thrust that the simulator takes away with time, in a log without the rotors' speeds"""
            head, *rows = [line.split(",") for line in log.read_text(encoding="utf-8").splitlines()]
            kept = [i for i, name in enumerate(head) if not name.startswith("rotor")]
            lines = [",".join([*(head[i] for i in kept), "vbat"])]
            lines += [",".join([*(row[i] for i in kept), f"{15.4 * (1 - 0.004 * float(row[0])) ** (1 / 1.5):.5f}"]) for row in rows]
            log.write_text("\n".join(lines) + "\n", encoding="utf-8")

        _, vehicle = self.fit([{"type": "battery_sag", "rate": 0.004}], "nominal_voltage_V = 15.4\n", with_voltage)
        sag = next(effect for effect in vehicle["effect"] if effect["type"] == "battery_sag")
        self.assertAlmostEqual(sag["exponent"], 1.5, delta=0.1)


class WrongInput(InFolder):
    def assert_refused(self, arguments, words, code=2):
        before = sorted(self.folder.rglob("*"))
        done = gustlab(*arguments, folder=self.folder)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(words, done.stderr)
        self.assertNotIn("terminate", done.stderr)
        self.assertEqual(sorted(self.folder.rglob("*")), before, "left something behind")

    def test_new(self):
        def changed(*pairs, drop=()):
            words = dict(zip(NEW[2::2], NEW[3::2])) | dict(pairs)
            return ["vehicle", "new", *(w for key, value in words.items() if key not in drop for w in (key, value))]

        # no vehicle hovers with so little
        weak = "thrust_N,speed_radps,throttle\n" + "".join(f"{1e-3 * i * i},{100 * i},{i / 9}\n" for i in range(1, 9))
        (self.folder / "weak.csv").write_text(weak, encoding="utf-8")
        (self.folder / "taken").mkdir()
        (self.folder / "taken" / "vehicle.toml").touch()
        (self.folder / "file").touch()
        for arguments, words in (
            (["vehicle"], "a command is missing"),
            (["vehicle", "nwe"], 'unknown command "nwe"; did you mean "new"?'),
            (changed(drop=["--mass"]), "--mass is required"),
            (changed(drop=["--arm"]), "--arm is missing"),
            (changed(("--mass", "1.2")), '--mass: "1.2" is not a number with a unit (units: kg, g, lb); write for example 1.2kg'),
            (changed(("--mass", "1.2t")), '--mass: "1.2t" is not a number with a unit'),
            (changed(("--mass", "heavy")), '--mass: "heavy" is not a number with a unit'),
            (changed(("--mass", "0kg")), '--mass: "0kg" is not above zero'),
            (changed(("--mass", "nan kg")), '--mass: "nan kg" is not above zero'),
            (changed(("--arm", "0.25kg")), "units: m, cm, mm, in"),
            (changed(("--prop", "40in")), "propellers of 1.016 m overlap"),
            (changed(("--prop", "ten in")), "--prop: "),
            (changed(("--thrust-to-weight", "0.9")), "does not fly"),
            (changed(("--thrust-to-weight", "x")), "--thrust-to-weight"),
            (changed(("--thrust-to-weight", "1e20")), "no multirotor pushes with more than 100 times its weight"),
            (changed(("--mass", "1e9kg")), "--mass: 1e+09 kg is no multirotor's"),
            (changed(drop=["--thrust-to-weight"]), "--thrust-to-weight or --hover is missing"),
            (changed(("--hover", "0.5")), "--hover and --thrust-to-weight are two answers to one question"),
            (changed(("--hover", "1.5"), drop=["--thrust-to-weight"]), "1.5 is no hover throttle"),
            (changed(("--throttle-curve", "3")), "--throttle-curve"),
            (changed(("--layout", "hex")), 'there is no layout "hex" (known: x, +, x-betaflight, x-crazyflie, hexa, hexa+, octo, octo+); did you mean "hexa"?'),
            (changed(("--from-px4", "no.ulg")), "no.ulg: cannot be read (No such file or directory)"),
            (changed(("--from-px4", "file")), "file: byte 0: the file is empty"),
            (changed(("--out", "taken")), "taken/vehicle.toml: is there already"),
            (changed(("--out", "file/below")), "file is a file, not a folder"),
        ):
            with self.subTest(words):
                self.assert_refused(arguments, words, 3 if "--from-px4" in arguments else 2)

    def test_check(self):
        self.write(LEAST)
        for arguments, words in (
            (["vehicle", "check"], "VEHICLE is required"),
            (["vehicle", "check", "crazyfly"], 'did you mean "crazyflie"?'),
            (["vehicle", "check", "no/vehicle.toml"], "cannot read (No such file or directory)"),
            (["vehicle", "check", "vehicle.toml"], "one required key is missing:\n  under [thrust] coefficient"),
            (["vehicle", "check", "crazyflie", "--format", "xml"], "--format"),
        ):
            with self.subTest(words):
                self.assert_refused(arguments, words)

    def test_fit(self):
        self.write(LEAST + "hover = 0.5\n")
        good = "thrust_N,speed_radps\n" + "".join(f"{i * i},{100 * i}\n" for i in range(1, 9))
        for name, text in (("good.csv", good), ("few.csv", "thrust_N,speed_radps\n1,100\n"), ("no_thrust.csv", "speed_radps\n100\n"),
                           ("down.csv", good.replace("\n", "\n-").removesuffix("-")), ("hole.csv", good.replace("4,200", ",200")),
                           ("word.csv", good.replace("200", "fast")), ("throttle.csv", "thrust_N,throttle\n" + "".join(f"{i},{i}\n" for i in range(9)))):
            (self.folder / name).write_text(text, encoding="utf-8")
        # no vehicle hovers with so little
        weak = "thrust_N,speed_radps,throttle\n" + "".join(f"{1e-3 * i * i},{100 * i},{i / 9}\n" for i in range(1, 9))
        (self.folder / "weak.csv").write_text(weak, encoding="utf-8")
        (self.folder / "taken").mkdir()
        (self.folder / "taken" / "vehicle.toml").touch()

        def stand(name, *more):
            return ["vehicle", "fit", "--thrust-stand", name, "--vehicle", "vehicle.toml", "--out", "o", *more]

        for arguments, words, code in (
            (["vehicle", "fit", "--out", "o"], "flight logs or --thrust-stand FILE.csv, one of them", 2),
            (["vehicle", "fit", "a.csv", "--thrust-stand", "good.csv", "--out", "o"], "one of them", 2),
            (["vehicle", "fit", "--thrust-stand", "good.csv", "--out", "o"], "--vehicle is missing", 2),
            (stand("good.csv")[:-2], "--out is required", 2),
            (stand("good.csv", "--holdout", "b.csv"), "has no flights to hold out", 2),
            (stand("good.csv")[:-1] + ["taken"], "taken/vehicle.toml: is there already", 2),
            (["vehicle", "fit", "no.csv", "--out", "o"], "no.csv: cannot read", 3),
            (["vehicle", "fit", "good.csv", "--holdout", "good.csv", "--out", "o"], "good.csv: is given twice", 2),
            (stand("weak.csv"), "weak.csv: the vehicle that it gives is refused: vehicle.toml", 3),
            (stand("no.csv"), "no.csv: cannot read", 3),
            (stand("few.csv"), "1 rows are too few (at least 5)", 3),
            (stand("no_thrust.csv"), 'column "thrust_N" is missing (or thrust_gf, thrust_kgf)', 3),
            (stand("down.csv"), "no row has thrust above zero", 3),
            (stand("hole.csv"), 'the cell of "thrust_N" is empty', 3),
            (stand("word.csv"), "word.csv:3:3:", 3),
            (stand("throttle.csv"), "throttle is from 0 to 1 and pulse_us from 1000 to 2000", 3),
        ):
            with self.subTest(words + arguments[-1]):
                self.assert_refused(arguments, words, code)

    def test_files(self):
        many = LEAST.replace('mjcf = "body.xml"\n', "site = 3\n") + "radius_m = -1\nfoo = 3\n"   # all of it is said in one message
        for text, words in (
            ("", "4 required keys are missing:"),
            ("format = 1\n", '"format" must be a string'),
            ('format = "gustlab-vehicle/1"\n', "3 required keys are missing:"),
            (LEAST + "hover = 0.5\nradius = 0.1\n", 'unknown key "radius"; did you mean "radius_m"?'),
            (LEAST + "hover = -0.5\n", '"hover" must be positive'),
            (many, "vehicle.toml: 2 required keys are missing:"),
            (many, '\nvehicle.toml:16:12: "radius_m" must be positive\n'),
            (many, '\nvehicle.toml:2:1: unknown key "site" (known: '),
            (many, '\nvehicle.toml:17:1: unknown key "foo" (known: '),
            (LEAST + 'hover = "half"\n', '"hover" must be a number'),
            (LEAST + "hover = 0.5\ncoefficient = 1e-5\n", "two answers to one question"),
            (LEAST + "coefficient = 1e-5\nmax_speed_radps = 10\n", "cannot hover"),
            (LEAST + "coefficient = inf\n", '"coefficient" must be finite'),
            (LEAST + "hover = 0.5\n[actuator]\nthrottle_curve = 1.5\n", "must be from 0 to 1"),
            (LEAST + "hover = 0.5\n[actuator]\nthrottle = { slope = 700 }\n", "both [thrust] hover and a map of throttle"),
            (LEAST.replace('"a"', '"z"') + "hover = 0.5\n", 'there is no site "z"'),
            (LEAST.replace("body.xml", "else.xml") + "hover = 0.5\n", "there is no file"),
        ):
            with self.subTest(words):
                self.write(text)
                self.assert_refused(["vehicle", "check", "vehicle.toml"], words)


class Templates(InFolder):
    def test_the_vehicle_template_is_a_vehicle(self):
        text = self.ok("defaults", "vehicle").replace("my_vehicle.xml", "body.xml")
        for i, site in enumerate("abcd", 1):
            text = text.replace(f'"rotor{i}"', f'"{site}"')
        self.write(text)
        self.assertEqual(self.check("vehicle.toml")["contradictions"], [])
        # what is commented out is known, too
        optional = [line[2:].split("#")[0] for line in text.splitlines() if line.startswith("# ") and " = " in line and "hover" not in line]
        for line in optional:
            if not line.startswith(("coefficient", "throttle_curve", "throttle_thrust", "pwm_thrust", "time_constant", "type")):
                tomllib.loads(line)

    def test_the_other_templates_are_toml(self):
        for name in ("sidecar", "column-map"):
            self.assertIn("format", tomllib.loads(self.ok("defaults", name)))
        done = gustlab("defaults", "vehicle", "--format", "json", folder=self.folder)
        self.assertEqual((done.returncode, done.stdout), (2, ""))


if __name__ == "__main__":
    unittest.main()
