"""Exports of a flight log, read back by the libraries of those formats; films; and what is refused."""

import csv
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import pyarrow.parquet
from mcap.reader import make_reader

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
sys.path.insert(0, str(SCRIPTS))

from gustlab_flights.flight_file import FlightFile  # noqa: E402
from gustlab_flights.to_mcap import messages  # noqa: E402

SIDECAR = 'format = "gustlab-flight/1"\nvehicle = "crazyflie"\nactuator = "rotor_speed"\nsource = "simulation"\nhold = "zoh"\n'


def run(script: str, *arguments) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(SCRIPTS / script), *map(str, arguments)], capture_output=True, text=True, timeout=300)


class WithFlight(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.log = self.root / "circle.csv"
        self.write()

    def write(self, sidecar: str = SIDECAR, drop: tuple = ()):
        """two seconds of a circle at 50 Hz; position in every second row only, as an import leaves it"""
        rng = np.random.default_rng(1)
        self.rows = []
        for k in range(100):
            t = 0.02 * k
            row = {"time_s": t}
            if k % 2 == 0:
                row |= {"px": np.cos(t), "py": np.sin(t), "pz": 1.0 + 0.1 * t}
            yaw = t + 0.5 * np.pi
            row |= {"vx": -np.sin(t), "vy": np.cos(t), "vz": 0.1, "qw": np.cos(0.5 * yaw), "qx": 0.0, "qy": 0.0, "qz": np.sin(0.5 * yaw),
                    "wx": 0.1, "wy": 0.2, "wz": 1.0, "ax": 0.3, "ay": -0.4, "az": 9.81,
                    "rpx": np.cos(t), "rpy": np.sin(t), "rpz": 1.0, "ryaw": yaw, "fx": 0.01, "fy": -0.02, "fz": 0.0, "vbat": 3.9}
            row |= {f"u{i}": 2000.0 + 10.0 * i + float(rng.normal()) for i in range(1, 5)}
            row |= {f"rotor{i}": 1990.0 + 10.0 * i for i in range(1, 5)}
            row["own_column"] = float(k)
            self.rows.append({name: value for name, value in row.items() if name not in drop})
        names = list(self.rows[0])
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow(names)
        for row in self.rows:
            writer.writerow([repr(float(row[name])) if name in row else "" for name in names])
        self.log.write_text(text.getvalue(), encoding="utf-8")
        self.log.with_name("circle.meta.toml").write_text(sidecar, encoding="utf-8")

    def column(self, name: str) -> np.ndarray:
        return np.array([row.get(name, np.nan) for row in self.rows])

    def refused(self, code: int, script: str, *arguments) -> str:
        done = run(script, *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        lines = done.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return lines[0]


class Exports(WithFlight):
    def test_parquet_has_every_cell_its_unit_and_the_sidecar(self):
        out = self.root / "circle.parquet"
        self.assertEqual(run("export_flight.py", self.log, "--out", out).returncode, 0)
        table = pyarrow.parquet.read_table(out)
        self.assertEqual(table.column_names, list(self.rows[0]))
        for name in table.column_names:
            read = table.column(name).to_pandas().to_numpy(dtype=float)
            np.testing.assert_array_equal(read, self.column(name), err_msg=name)
        self.assertEqual(table.column("px").null_count, 50)
        self.assertEqual(table.schema.field("vx").metadata[b"unit"], b"m/s")
        self.assertEqual(table.schema.field("u1").metadata[b"unit"], b"rad/s")
        self.assertEqual(table.schema.metadata[b"sidecar"].decode(), SIDECAR)

    def test_mcap_has_every_sample_at_its_time(self):
        out = self.root / "circle.mcap"
        self.assertEqual(run("export_flight.py", self.log, "--to", "mcap", "--out", out).returncode, 0)
        found = {}
        with open(out, "rb") as file:
            reader = make_reader(file)
            for schema, channel, message in reader.iter_messages():
                self.assertEqual((schema.encoding, channel.message_encoding), ("jsonschema", "json"))
                found.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
                self.assertEqual(schema.name == "foxglove.PoseInFrame", channel.topic in ("/pose", "/reference_pose"))
            self.assertEqual([a.name for a in reader.iter_attachments()], ["circle.meta.toml"])
        self.assertEqual(len(found["/position"]), 50)
        self.assertEqual(len(found["/velocity"]), 100)
        for topic, name in (("/position", "px"), ("/actuator_input", "u3"), ("/own_column", "own_column")):
            sampled = [row for row in self.rows if name in row]
            self.assertEqual([t for t, _ in found[topic]], [round(1e9 * row["time_s"]) for row in sampled])
            np.testing.assert_array_equal([m[name] for _, m in found[topic]], [row[name] for row in sampled])
        ns, pose = found["/pose"][10]
        self.assertEqual((pose["timestamp"], pose["frame_id"]), ({"sec": 0, "nsec": 400_000_000}, "world"))
        self.assertEqual(ns, 400_000_000)
        self.assertAlmostEqual(pose["pose"]["position"]["y"], np.sin(0.4))
        self.assertAlmostEqual(pose["pose"]["orientation"]["w"], np.cos(0.5 * (0.4 + 0.5 * np.pi)))

    def test_a_pose_between_attitudes_has_the_last_one(self):
        flight = FlightFile(self.log)
        for name in ("qw", "qx", "qy", "qz"):
            flight.columns[name][::2] = np.nan
        _, found = messages(flight)
        poses = [message for _, topic, message in found if topic == "/pose"]
        self.assertEqual(poses[0]["pose"]["orientation"]["w"], 1.0)  # before the first attitude: level
        self.assertAlmostEqual(poses[1]["pose"]["orientation"]["z"], np.sin(0.5 * (0.02 + 0.5 * np.pi)))

    def test_topics_are_those_of_px4_and_read_back_as_the_same_flight(self):
        out = self.root / "topics"
        self.assertEqual(run("export_flight.py", self.log, "--to", "csv", "--out", out).returncode, 0)
        tables = {}
        for path in out.iterdir():
            with open(path, encoding="utf-8", newline="") as file:
                tables[path.name.removeprefix("circle_").removesuffix("_0.csv")] = list(csv.DictReader(file))
        self.assertEqual(set(tables), {"vehicle_local_position", "vehicle_attitude", "vehicle_angular_velocity", "vehicle_acceleration",
                                       "trajectory_setpoint", "actuator_outputs", "esc_status", "battery_status", "gustlab"})
        position = tables["vehicle_local_position"]
        self.assertEqual((position[20]["timestamp"], position[1]["x"]), ("400000", ""))
        # north is the log's y, down its -z
        self.assertAlmostEqual(float(position[20]["x"]), np.sin(0.4), places=8)
        self.assertAlmostEqual(float(position[20]["y"]), np.cos(0.4), places=8)
        self.assertAlmostEqual(float(position[20]["z"]), -1.04, places=8)
        self.assertAlmostEqual(float(position[20]["vz"]), -0.1, places=8)
        self.assertEqual([float(tables["vehicle_angular_velocity"][0][f"xyz[{i}]"]) for i in range(3)], [0.1, -0.2, -1.0])
        self.assertAlmostEqual(float(tables["esc_status"][0]["esc[0].esc_rpm"]), 2000.0 * 60.0 / (2.0 * np.pi), places=3)
        # yaw of the log is counter-clockwise from x (east); PX4's clockwise from north
        w, z = (float(tables["vehicle_attitude"][50][f"q[{i}]"]) for i in (0, 3))
        yaw_ned = 2.0 * np.arctan2(z, w)
        self.assertAlmostEqual(np.cos(yaw_ned - (0.5 * np.pi - (1.0 + 0.5 * np.pi))), 1.0, places=8)
        self.assertAlmostEqual(float(tables["trajectory_setpoint"][50]["yaw"]), -1.0, places=8)

    def test_the_same_input_gives_the_same_bytes(self):
        for ending in ("parquet", "mcap"):
            outs = [self.root / f"{n}.{ending}" for n in "ab"]
            for out in outs:
                self.assertEqual(run("export_flight.py", self.log, "--out", out).returncode, 0)
            self.assertEqual(outs[0].read_bytes(), outs[1].read_bytes())

    def test_what_cannot_be_exported_is_one_line(self):
        self.assertIn("its ending names no kind", self.refused(2, "export_flight.py", self.log, "--out", self.root / "x.xyz"))
        self.assertIn("is an input of this command", self.refused(2, "export_flight.py", self.log, "--to", "mcap", "--out", self.log))
        self.assertIn("cannot be read", self.refused(3, "export_flight.py", self.root / "no.csv", "--out", self.root / "x.mcap"))
        self.assertIn("no flight.csv in this folder", self.refused(3, "export_flight.py", self.root, "--out", self.root / "x.mcap"))
        self.log.write_text("a,b\n1,2\n")
        self.assertIn("no column time_s", self.refused(3, "export_flight.py", self.log, "--out", self.root / "x.mcap"))
        self.log.write_text("time_s,px\n1,2\n1,2\n")
        self.assertIn("does not increase", self.refused(3, "export_flight.py", self.log, "--out", self.root / "x.mcap"))
        self.log.write_text("time_s,px\n-1,2\n1,2\n")
        self.assertIn("before zero", self.refused(3, "export_flight.py", self.log, "--out", self.root / "x.mcap"))
        self.log.write_text("time_s,px\n1,2\n9e10,2\n")
        late = self.refused(3, "export_flight.py", self.log, "--out", self.root / "x.mcap")
        self.assertIn("circle.csv:3:1: time_s is 9e+10 s, and MCAP holds", late)
        self.assertIn("\\x1b[1m.csv: cannot be read", self.refused(3, "export_flight.py", "\x1b[1m.csv", "--out", self.root / "x.mcap"))
        self.assertIn("\\x1b[1m", self.refused(2, "export_flight.py", "--out", self.root / "x.mcap", self.log, "--\x1b[1m"))
        self.log.with_name("circle.meta.toml").write_text("= nothing")
        self.assertIn("circle.meta.toml", self.refused(3, "export_flight.py", self.log, "--out", self.root / "x.parquet"))
        self.assertFalse(list(self.root.glob("x.*")) + list(self.root.glob(".gustlab*")))


class Pandas(WithFlight):
    def test_the_lines_of_the_documentation_run(self):
        import re
        blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / "EXPORTS.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
        self.assertEqual(len(blocks), 2)
        (self.root / "flight.csv").write_bytes(self.log.read_bytes())
        lines = ["experiment,vehicle,trajectory,controller,replicate,outcome,duration_s,rmse_xy_m,mae_xy_m,p95_xy_m,max_xy_m,rmse_z_m,key"]
        for replicate in (1, 2):
            for controller, error in (("pid", 0.4), ("indi", 0.1)):
                lines.append(f"t,iris,circle,{controller},{replicate},completed,1,{error * replicate},0,0,0,0,k")
        (self.root / "runs.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        printed = []
        for block in blocks:
            done = subprocess.run([sys.executable, "-c", block], cwd=self.root, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            printed.append(done.stdout)
        self.assertRegex(printed[0], r"RMSE 0\.0\b")  # flown where it should be
        self.assertRegex(printed[1], r"mean +0\.45")  # 0.3 and 0.6 m


class Films(WithFlight):
    def pictures(self, **options):
        """(first picture, last picture, Motion) of a small film"""
        from gustlab_flights import render
        argv = [str(self.log), "--out", "x.gif", "--size", "192x128", "--fps", "5"] + [part for pair in options.items() for part in pair]
        drawn = render.Pictures(FlightFile(self.log), render.arguments(argv))
        try:
            return drawn.draw(0), drawn.draw(len(drawn) - 1), drawn.shown
        finally:
            drawn.close()

    def near(self, picture, color, most=60) -> int:
        """pixels about as coloured"""
        return int(np.sum(np.abs(picture.astype(int) - np.round(255 * np.array(color[:3]))).sum(axis=2) < most))

    def test_vehicle_paths_and_arrows_are_drawn(self):
        from gustlab_flights import scene
        first, last, shown = self.pictures()
        self.assertEqual(first.shape, (128, 192, 3))
        self.assertGreater(self.near(last, scene.FLOWN), self.near(first, scene.FLOWN) + 20)  # the path grows
        np.testing.assert_allclose(np.linalg.norm(shown.attitude, axis=1), 1.0)
        np.testing.assert_allclose(shown.position[:, 0], np.cos(shown.time_s), atol=2e-4)
        # 2000 to 2030 rad/s against the hover of a crazyflie
        self.assertGreater(shown.lift.min(), 0.5)
        self.assertLess(shown.lift.max(), 2.0)
        self.write(drop=("rpx", "rpy", "rpz", "fx", "fy", "fz"))
        _, bare, without = self.pictures()
        self.assertIsNone(without.reference)
        self.assertIsNone(without.gust_N)
        self.assertLess(self.near(bare, scene.GUST), self.near(last, scene.GUST) + 1)

    def test_an_arrow_is_as_long_as_what_it_shows(self):
        from gustlab_flights import render, scene
        drawn = render.Pictures(FlightFile(self.log), render.arguments([str(self.log), "--out", "x.gif", "--size", "400x400"]))
        try:
            camera = drawn.camera.look(0)
            camera.lookat[:], camera.distance, camera.elevation = (0.0, 0.0, 1.2), 1.5, 0.0
            drawn.renderer.update_scene(drawn.scene.data, camera)
            # an arrow and a line of the same height, equally far from the camera, left and right of the vehicle
            turn = np.radians(camera.azimuth)
            aside = 0.3 * np.array([-np.sin(turn), np.cos(turn), 0.0])
            low, high = np.array([0.0, 0.0, 1.1]), np.array([0.0, 0.0, 1.5])
            drawn.scene._arrow(drawn.renderer.scene, low - aside, high - aside, 0.05, scene.GUST)
            drawn.scene._path(drawn.renderer.scene, np.array([low + aside, high + aside]), scene.FLOWN, 3.0)
            picture = drawn.renderer.render().astype(int)
            orange = np.flatnonzero((picture[:, :, 0] - picture[:, :, 2] > 60).any(axis=1))
            blue = np.flatnonzero((picture[:, :, 2] - picture[:, :, 0] > 60).any(axis=1))
            self.assertGreater(len(blue), 50)
            self.assertAlmostEqual(np.ptp(orange) / np.ptp(blue), 1.0, delta=0.1)
        finally:
            drawn.close()

    def test_films_are_written_whole(self):
        for ending, mark, at in (("mp4", b"ftyp", 4), ("gif", b"GIF8", 0)):
            out = self.root / f"film.{ending}"
            done = run("render_flight.py", self.log, "--out", out, "--size", "128x96", "--fps", "5")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(out.read_bytes()[at:at + 4], mark)
        from PIL import Image
        with Image.open(self.root / "film.gif") as film:
            self.assertEqual((film.n_frames, film.size), (10, (128, 96)))

    def test_a_film_that_ffmpeg_could_not_write_is_none(self):
        # ffmpeg is another program, which a full disk of ours does not reach: a limit of a file's size stands for it
        out = self.root / "film.mp4"
        done = subprocess.run([sys.executable, str(SCRIPTS / "render_flight.py"), str(self.log), "--out", str(out), "--size", "128x96", "--fps", "5"],
                              capture_output=True, text=True, timeout=120, env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},  # or modules are cut as well
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048)))
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("film.mp4: cannot be written", done.stderr)
        self.assertEqual([path.name for path in self.root.iterdir() if "film" in path.name or path.name.startswith(".")], [])

    def test_what_cannot_be_drawn_is_one_line(self):
        out = self.root / "x.mp4"
        for code, words, arguments in ((2, "ends in .mp4 or .gif", ["--out", self.root / "x.avi"]), (2, "--size", ["--out", out, "--size", "3"]),
                                       (2, "--fps", ["--out", out, "--fps", "1e9"]), (2, "--fps 0", ["--out", out, "--fps", "0"]), (2, "--speed", ["--out", out, "--speed", "-1"]),
                                       (2, "nothing of the flight", ["--out", out, "--from", "9"]),
                                       (2, "no vehicle of this name", ["--out", out, "--vehicle", "crazyfly"])):
            self.assertIn(words, self.refused(code, "render_flight.py", self.log, *arguments))
        self.write(sidecar="")
        self.assertIn("names no vehicle", self.refused(2, "render_flight.py", self.log, "--out", out))
        self.write(drop=("px", "py", "pz"))
        self.assertIn("no position", self.refused(3, "render_flight.py", self.log, "--out", out))
        self.assertFalse(out.exists())

    def test_a_time_that_would_take_endless_pictures_is_refused_at_its_cell(self):
        lines = self.log.read_text().splitlines()
        self.log.write_text("\n".join([*lines[:-1], "9e10," + lines[-1].partition(",")[2]]) + "\n")
        for script, *arguments in (("render_flight.py", "--out", self.root / "x.gif"), ("view_flight.py",)):
            self.assertIn("circle.csv:101:1: time_s goes from 1.96 to 9e+10 s here", self.refused(3, script, self.log, *arguments))
        part = run("render_flight.py", self.log, "--to", "1", "--out", self.root / "x.gif", "--size", "64x64", "--fps", "5")
        self.assertEqual(part.returncode, 0, part.stderr)

    def test_the_viewer_refuses_a_speed_that_shows_nothing(self):
        self.assertIn("--speed 0: from 0.01", self.refused(2, "view_flight.py", self.log, "--speed", "0"))

    def test_the_viewer_says_that_it_needs_a_display(self):
        import os
        environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        done = subprocess.run([sys.executable, str(SCRIPTS / "view_flight.py"), str(self.log)], capture_output=True, text=True, timeout=60,
                              env=environment)
        self.assertEqual(done.returncode, 4)
        self.assertEqual(done.stderr, "view: no display can be opened here; `gustlab render FLIGHT --out film.mp4` needs none\n")


if __name__ == "__main__":
    unittest.main()
