"""A flight as a MuJoCo scene: the vehicle where it was, its path and reference, and arrows for gust and rotors."""

import os
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from gustlab_import.toml_text import parse_toml
from gustlab_import.vehicle_file import find_vehicle

from .flight_file import FlightFile
from .problems import DATA, USAGE, Refusal

GRAVITY_MPS2 = 9.81
# Okabe and Ito: flown, reference, gust, rotors
FLOWN, REFERENCE, GUST, ROTOR = (0.0, 0.45, 0.70, 1.0), (0.45, 0.45, 0.45, 0.8), (0.84, 0.37, 0.0, 1.0), (0.0, 0.62, 0.45, 1.0)
PLUMB = (0.55, 0.57, 0.60, 0.7)
LONGEST_LINE = 600  # pieces of a path that are drawn
MOST_PICTURES = 1_000_000  # nine hours at 30 a second


@dataclass
class Motion:
    """Everything that is drawn, at the times of the pictures; None where the log does not have it."""

    time_s: np.ndarray
    position: np.ndarray  # (n, 3)
    attitude: np.ndarray  # (n, 4)
    reference: np.ndarray | None  # (n, 3)
    gust_N: np.ndarray | None  # (n, 3) world
    lift: np.ndarray | None  # (n, rotors), 1: hover


def vehicle_file(flight: FlightFile, wanted: str | None) -> Path:
    """The vehicle.toml that --vehicle or the sidecar names."""
    named = wanted or flight.sidecar.get("vehicle")
    if not named:
        raise Refusal(f"{flight.path}: its sidecar names no vehicle; give --vehicle", USAGE)
    return find_vehicle(str(named), Path() if wanted else flight.path.parent)


def _between(group, time_s: np.ndarray):
    """Samples interpolated to the times of the pictures, and held outside of them."""
    if group is None or not len(group.complete().time_s):
        return None
    whole = group.complete()
    return np.column_stack([np.interp(time_s, whole.time_s, column) for column in whole.values.T])


def _attitudes(group, time_s: np.ndarray) -> np.ndarray:
    if group is None or len(group.columns) < 4:
        return np.tile([1.0, 0.0, 0.0, 0.0], (len(time_s), 1))
    whole = group.complete()
    q = whole.values.copy()
    # neighbours on the same side of the sphere, so that the mean of two is between them
    signs = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    q[1:] *= np.cumprod(signs)[:, None]
    mixed = np.column_stack([np.interp(time_s, whole.time_s, column) for column in q.T])
    return mixed / np.linalg.norm(mixed, axis=1)[:, None]


def _lift(flight: FlightFile, vehicle: dict, weight_N: float, time_s: np.ndarray):
    """Thrust of each rotor as a multiple of its share of the weight; without a map, input over its own median."""
    speeds = _between(flight.group("rotor_speed"), time_s)
    inputs = _between(flight.group("actuator_input"), time_s)
    if speeds is None and flight.input_kind == "rotor_speed":
        speeds = inputs
    if speeds is not None:
        coefficient = vehicle.get("thrust", {}).get("coefficient")
        thrust = speeds**2
        share = weight_N / speeds.shape[1] / coefficient if coefficient else np.median(thrust)
        return thrust / share
    if inputs is None or inputs.shape[1] < 3:
        return None
    middle = np.median(inputs)
    return inputs / middle if middle > 0.0 else None


def picture_times(flight: FlightFile, first_s: float, last_s: float, step_s: float) -> np.ndarray:
    """From first to last; what a single cell makes endless is refused at that cell."""
    count = (last_s - first_s) / step_s + 1.0
    if count > MOST_PICTURES:
        row = int(np.argmax(np.diff(flight.time_s)))
        before_s, after_s = flight.time_s[row:row + 2]
        raise Refusal(f"{flight.place(row + 1, 'time_s')}: time_s goes from {before_s:g} to {after_s:g} s here, and {first_s:g} to "
                      f"{last_s:g} s are {count:.2g} pictures ({MOST_PICTURES} at most); mend the log, or draw a part of it", DATA)
    return first_s + step_s * np.arange(int(count))


def motion(flight: FlightFile, vehicle: dict, weight_N: float, time_s: np.ndarray) -> Motion:
    position = flight.group("position")
    if position is None or len(position.columns) < 3 or len(position.complete().time_s) < 2:
        raise Refusal(f"{flight.path}: no position is recorded, so there is no path to draw", DATA)
    return Motion(time_s, _between(position, time_s), _attitudes(flight.group("attitude"), time_s),
                  _between(flight.group("reference_position"), time_s), _between(flight.group("disturbance_force"), time_s),
                  _lift(flight, vehicle, weight_N, time_s))


class Scene:
    """The compiled model, and what is drawn into it."""

    def __init__(self, path: Path, floor_m: float, size: tuple):
        import mujoco
        self.mujoco, self.floor_m = mujoco, floor_m
        try:
            self.vehicle = parse_toml(path.read_text(encoding="utf-8"))
            mjcf = path.parent / str(self.vehicle.get("mjcf", ""))
            spec = mujoco.MjSpec.from_file(str(mjcf))
            self._dress(spec, floor_m, size)
            self.model = spec.compile()
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, ValueError) as error:
            raise Refusal(f"{path}: cannot be drawn ({' '.join(str(error).split())})", DATA) from None
        self.data = mujoco.MjData(self.model)
        free = np.flatnonzero(self.model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        if not len(free):
            raise Refusal(f"{mjcf}: no body with a free joint", DATA)
        self.address = int(self.model.jnt_qposadr[free[0]])
        self.body = int(self.model.jnt_bodyid[free[0]])
        mujoco.mj_forward(self.model, self.data)
        self.weight_N = float(self.model.body_subtreemass[self.body]) * GRAVITY_MPS2
        named = [rotor.get("site") for rotor in self.vehicle.get("rotor", [])]
        self.sites = [self.model.site(name).id for name in named if name]
        places = self.data.site_xpos[self.sites] - self.data.xpos[self.body]
        self.span_m = 2.0 * float(np.max(np.linalg.norm(places, axis=1))) if len(places) else 0.3

    def _dress(self, spec, floor_m: float, size: tuple) -> None:
        """Sky, floor with a grid of one metre, light, and a body where the file draws none."""
        mujoco = self.mujoco
        spec.visual.global_.offwidth, spec.visual.global_.offheight = size
        # bright enough together, and no colour of a line beyond white
        spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.4] * 3, [0.2] * 3
        spec.visual.headlight.specular = [0.0] * 3
        for light in spec.worldbody.lights:
            # a shadow costs more than all else that is drawn; a plumb line shows the height
            light.diffuse, light.specular, light.castshadow = [0.45] * 3, [0.1] * 3, False
        spec.visual.map.zfar = 200.0
        spec.add_texture(name="gustlab_sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
                         rgb1=[0.85, 0.90, 0.95], rgb2=[0.60, 0.68, 0.76], width=128, height=768)
        spec.add_texture(name="gustlab_grid", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
                         mark=mujoco.mjtMark.mjMARK_EDGE, rgb1=[0.90, 0.91, 0.92], rgb2=[0.86, 0.87, 0.89],
                         markrgb=[0.74, 0.76, 0.79], width=256, height=256)
        grid = spec.add_material(name="gustlab_floor", texuniform=True, texrepeat=[1, 1], reflectance=0.0, specular=0.0)
        grid.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "gustlab_grid"
        for geom in spec.worldbody.geoms:
            if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
                geom.rgba = [0.0] * 4
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.1], pos=[0, 0, floor_m], material="gustlab_floor",
                                contype=0, conaffinity=0)
        for body in spec.worldbody.bodies:
            if not any(geom.group < 3 and geom.rgba[3] > 0.0 for geom in body.geoms):
                self._draw_body(body)

    def _draw_body(self, body) -> None:
        """Arms to the rotor sites, and a disc on each."""
        mujoco = self.mujoco
        places = [site.pos for site in body.sites]
        reach = max((float(np.linalg.norm(place)) for place in places), default=0.15)
        for place in places:
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.04 * reach, 0, 0], fromto=[0, 0, 0, *place],
                          rgba=[0.15, 0.15, 0.15, 1], contype=0, conaffinity=0, mass=0)
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.45 * reach, 0.02 * reach, 0], pos=place,
                          rgba=[0.2, 0.2, 0.2, 0.5], contype=0, conaffinity=0, mass=0)

    def place(self, shown: Motion, k: int) -> None:
        self.data.qpos[self.address:self.address + 3] = shown.position[k]
        self.data.qpos[self.address + 3:self.address + 7] = shown.attitude[k]
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_comPos(self.model, self.data)
        self.mujoco.mj_camlight(self.model, self.data)

    def decorate(self, scene, shown: Motion, k: int) -> None:
        """Adds paths and arrows to a mjvScene."""
        if shown.reference is not None:
            self._path(scene, shown.reference, REFERENCE, 1.5)
        self._path(scene, shown.position[:k + 1], FLOWN, 3.0)
        middle = shown.position[k]
        foot = [middle[0], middle[1], self.floor_m]
        self._add(scene, self.mujoco.mjtGeom.mjGEOM_LINE, 1.0, middle, foot, PLUMB)
        self._add(scene, self.mujoco.mjtGeom.mjGEOM_CYLINDER, 0.1 * self.span_m, foot, [*foot[:2], self.floor_m + 0.002], PLUMB)
        if shown.gust_N is not None:
            # as long as five spans where the gust pushes with the weight
            self._arrow(scene, middle, middle + 5.0 * self.span_m / self.weight_N * shown.gust_N[k], 0.05, GUST)
        if shown.lift is not None:
            for site, lift in zip(self.sites, shown.lift[k]):
                foot = self.data.site_xpos[site]
                up = self.data.site_xmat[site].reshape(3, 3)[:, 2]
                self._arrow(scene, foot, foot + 0.45 * self.span_m * lift * up, 0.02, ROTOR)

    def _add(self, scene, kind, width: float, start, end, color) -> None:
        if scene.ngeom >= scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        self.mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.zeros(9), np.array(color, dtype=np.float32))
        self.mujoco.mjv_connector(geom, kind, width, np.asarray(start, dtype=float), np.asarray(end, dtype=float))
        scene.ngeom += 1

    def _path(self, scene, points: np.ndarray, color, width: float) -> None:
        chosen = points[np.unique(np.linspace(0, len(points) - 1, min(len(points), LONGEST_LINE)).astype(int))]
        for start, end in zip(chosen[:-1], chosen[1:]):
            self._add(scene, self.mujoco.mjtGeom.mjGEOM_LINE, width, start, end, color)

    def _arrow(self, scene, start, end, width: float, color) -> None:
        # MuJoCo draws an arrow half as long as it is told
        reach = 2.0 * (np.asarray(end) - start)
        if np.linalg.norm(reach) > 1e-3 * self.span_m:
            self._add(scene, self.mujoco.mjtGeom.mjGEOM_ARROW, width * self.span_m, start, start + reach, color)


def floor_of(flight: FlightFile) -> float:
    """Height of the ground: what the sidecar says, else just below the lowest point of the flight."""
    known = flight.sidecar.get("environment", {}).get("ground_z_m")
    lowest = flight.columns["pz"][np.isfinite(flight.columns["pz"])] if "pz" in flight.columns else np.zeros(0)
    if isinstance(known, (int, float)):
        return float(known)
    return min(0.0, float(np.min(lowest)) - 0.1) if len(lowest) else 0.0


def use_software() -> None:
    """Pictures without a display: MuJoCo chooses by this when it is imported."""
    os.environ.setdefault("MUJOCO_GL", "osmesa")
    os.environ.setdefault("PYOPENGL_PLATFORM", os.environ["MUJOCO_GL"])
