"""gustlab render: a flight as a film."""

import io
import tempfile
from argparse import Namespace
from pathlib import Path

import numpy as np
from gustlab_import.command_line import Options, seconds
from gustlab_import.interrupts import throw_if_interrupted
from gustlab_import.outputs import STDOUT, check_outputs, write_outputs
from gustlab_import.progress import Progress

from . import scene as scenes
from .flight_file import FlightFile
from .problems import IO, USAGE, Refusal

ENDINGS = (".mp4", ".gif")


def arguments(argv: list) -> Namespace:
    parser = Options(prog="gustlab render", description="draws a flight as a film: the vehicle, its path (blue) and "
                                     "reference (grey), the gust (orange; as long as five vehicles where it pushes with the weight) "
                                     "and the rotors' thrust (green)", epilog="needs no display. exit codes: 0 written, 2 usage, 3 "
                                     "the log cannot be drawn, 4 a file cannot be read or written")
    parser.add_argument("flight", type=Path, metavar="FLIGHT", help="a flight log NAME.csv[.gz], or the --out of `gustlab run`")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.mp4|FILE.gif", help="the film")
    parser.add_argument("--vehicle", metavar="NAME|PATH", help="vehicle (default: the sidecar's)")
    parser.add_argument("--camera", choices=("whole", "follow"), help="the whole path, or close behind the vehicle (default: whole "
                        "where the vehicle is then still seen)")
    parser.add_argument("--from", dest="from_s", type=seconds, metavar="S", help="first time of the log that is drawn")
    parser.add_argument("--to", dest="to_s", type=seconds, metavar="S", help="last time of the log that is drawn")
    parser.add_argument("--speed", type=float, default=1.0, metavar="X", help="times faster than real time (default: 1)")
    parser.add_argument("--fps", type=float, metavar="N", help="pictures a second (default: 30; gif: 15)")
    parser.add_argument("--size", default=None, metavar="WxH", help="pixels (default: 960x540; gif: 480x270)")
    parser.add_argument("-q", "--quiet", action="store_true", help="errors only")
    options = parser.parse_args(argv)
    if options.out == STDOUT:
        raise Refusal("--out -: the ending of a name says what kind of film it is, and stdout has none; name a file or a FIFO", USAGE)
    if options.out.suffix not in ENDINGS:
        raise Refusal(f"--out {options.out}: a film ends in .mp4 or .gif", USAGE)
    film = options.out.suffix == ".mp4"
    options.fps = (30.0 if film else 15.0) if options.fps is None else options.fps
    options.size = _size(options.size or ("960x540" if film else "480x270"))
    if not 0.1 <= options.fps <= 120.0:
        raise Refusal(f"--fps {options.fps:g}: from 0.1 to 120", USAGE)
    if not 0.01 <= options.speed <= 1000.0:
        raise Refusal(f"--speed {options.speed:g}: from 0.01 to 1000", USAGE)
    return options


def _size(text: str) -> tuple:
    try:
        width, height = (int(part) for part in text.split("x"))
    except ValueError:
        raise Refusal(f"--size {text}: two numbers of pixels, as 960x540", USAGE) from None
    if not (64 <= width <= 3840 and 64 <= height <= 2160) or width % 2 or height % 2:
        raise Refusal(f"--size {text}: even numbers from 64x64 to 3840x2160", USAGE)
    return width, height


def picture_times(flight: FlightFile, options: Namespace) -> np.ndarray:
    time_s = flight.time_s
    first = time_s[0] if options.from_s is None else max(time_s[0], options.from_s)
    last = time_s[-1] if options.to_s is None else min(time_s[-1], options.to_s)
    step = options.speed / options.fps
    if last - first < step:
        raise Refusal(f"--from, --to: nothing of the flight ({time_s[0]:g} to {time_s[-1]:g} s) is between them", USAGE)
    return scenes.picture_times(flight, first, last, step)


class Camera:
    """Looks down at the path from its side; follow keeps the vehicle's size."""

    def __init__(self, mujoco, shown: scenes.Motion, span_m: float, wanted: str | None):
        self.camera = mujoco.MjvCamera()
        points = shown.position if shown.reference is None else np.vstack([shown.position, shown.reference])
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.extent = float(np.linalg.norm(self.high - self.low))
        whole = max(1.15 * self.extent, 5.0 * span_m)
        self.follow = wanted == "follow" or (wanted is None and whole > 40.0 * span_m)
        self.camera.distance = 7.0 * span_m if self.follow else whole
        self.camera.elevation, self.camera.azimuth = -24.0, 60.0
        # the camera does not shake with the vehicle: a moving average over half a second
        window = max(1, int(0.5 / max(1e-9, float(np.median(np.diff(shown.time_s))))))
        padded = np.pad(shown.position, ((window, window), (0, 0)), mode="edge")
        smooth = np.column_stack([np.convolve(column, np.full(window, 1.0 / window), mode="same") for column in padded.T])
        self.middle = smooth[window:-window]

    def look(self, k: int):
        self.camera.lookat[:] = self.middle[k] if self.follow else 0.5 * (self.low + self.high)
        return self.camera


def caption(shown: scenes.Motion, k: int) -> list:
    """(text, colour) of the lines in the corner."""
    lines = [(f"{shown.time_s[k]:.1f} s", (0.15, 0.15, 0.15))]
    if shown.reference is not None:
        error_m = float(np.linalg.norm(shown.position[k] - shown.reference[k]))
        lines.append((f"{100.0 * error_m:.0f} cm from the reference", scenes.REFERENCE))
    if shown.gust_N is not None:
        lines.append((f"gust {np.linalg.norm(shown.gust_N[k]):.2g} N", scenes.GUST))
    if shown.lift is not None:
        lines.append(("rotor thrust", scenes.ROTOR))
    return lines


class Pictures:
    """The pictures of a flight, one after the other."""

    def __init__(self, flight: FlightFile, options: Namespace):
        times = picture_times(flight, options)
        scenes.use_software()
        self.scene = scenes.Scene(scenes.vehicle_file(flight, options.vehicle), scenes.floor_of(flight), options.size)
        self.shown = scenes.motion(flight, self.scene.vehicle, self.scene.weight_N, times)
        self.camera = Camera(self.scene.mujoco, self.shown, self.scene.span_m, options.camera)
        width, height = options.size
        # a camera that is near may stand inside the default near plane
        self.scene.model.vis.map.znear = 0.05 * self.camera.camera.distance / self.scene.model.stat.extent
        self.font_px = max(11, height // 30)
        try:
            self.renderer = self.scene.mujoco.Renderer(self.scene.model, height, width, max_geom=3 * scenes.LONGEST_LINE)
        except (RuntimeError, ImportError, AttributeError) as error:
            raise Refusal(f"no software renderer is here ({error}); run scripts/setup.sh, which installs libosmesa6", IO) from None

    def __len__(self) -> int:
        return len(self.shown.time_s)

    def draw(self, k: int):
        """(height, width, 3) bytes."""
        from PIL import Image, ImageDraw
        self.scene.place(self.shown, k)
        self.renderer.update_scene(self.scene.data, self.camera.look(k))
        self.scene.decorate(self.renderer.scene, self.shown, k)
        image = Image.fromarray(self.renderer.render())
        pen, y = ImageDraw.Draw(image), self.font_px // 2
        for text, color in caption(self.shown, k):
            pen.text((self.font_px, y), text, font=_font(self.font_px), fill=tuple(round(255 * part) for part in color[:3]))
            y += round(1.35 * self.font_px)
        return np.asarray(image)

    def close(self) -> None:
        self.renderer.close()


_fonts = {}


def _font(size_px: int):
    """matplotlib brings a font that any machine then has"""
    from PIL import ImageFont
    if size_px not in _fonts:
        import matplotlib
        _fonts[size_px] = ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), size_px)
    return _fonts[size_px]


def frames(pictures: Pictures, progress: Progress):
    for k in range(len(pictures)):
        throw_if_interrupted()
        yield pictures.draw(k)
        progress.show(k + 1, len(pictures))


def mp4(pictures: Pictures, options: Namespace, progress: Progress) -> bytes:
    """ffmpeg goes back in what it has written: a file of its own."""
    with tempfile.TemporaryDirectory(prefix="gustlab-") as folder:
        path = Path(folder) / "film.mp4"
        _run_ffmpeg(pictures, path, options, progress)
        return path.read_bytes()


def _run_ffmpeg(pictures: Pictures, path: Path, options: Namespace, progress: Progress) -> None:
    import imageio_ffmpeg
    film = imageio_ffmpeg.write_frames(str(path), options.size, fps=options.fps, codec="libx264", pix_fmt_out="yuv420p", macro_block_size=2,
                                       output_params=["-crf", "21", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1"],
                                       ffmpeg_log_level="error")
    try:
        film.send(None)
        for picture in frames(pictures, progress):
            film.send(np.ascontiguousarray(picture))
    except SystemExit as end:
        film.throw(end)  # which kills ffmpeg
    film.close()
    # what ffmpeg could not write, it says on stderr, and nobody hears of it
    try:
        written = imageio_ffmpeg.count_frames_and_secs(str(path))[0]
    except RuntimeError:
        written = 0
    if written != len(pictures):
        raise OSError(0, f"the film has {written} of {len(pictures)} pictures")


def gif(pictures: Pictures, options: Namespace, progress: Progress) -> bytes:
    from PIL import Image
    first, *more = [Image.fromarray(picture).quantize(colors=128, method=Image.Quantize.FASTOCTREE)
                    for picture in frames(pictures, progress)]
    film = io.BytesIO()
    first.save(film, format="GIF", save_all=True, append_images=more, duration=round(1000.0 / options.fps), loop=0)
    return film.getvalue()


def run(argv: list) -> int:
    options = arguments(argv)
    flight = FlightFile(options.flight)
    inputs = (flight.path, flight.sidecar_path)
    check_outputs([options.out], inputs)
    pictures = Pictures(flight, options)
    progress = Progress("pictures", options.quiet)
    try:
        film = (mp4 if options.out.suffix == ".mp4" else gif)(pictures, options, progress)
    except OSError as error:
        raise Refusal(f"{options.out}: cannot be written ({error.strerror or error})", IO) from None
    finally:
        progress.end()
        pictures.close()
    write_outputs({options.out: film}, inputs)
    return 0
