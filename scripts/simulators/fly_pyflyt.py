"""Flies PyFlyt's Crazyflie along the circle: one QuadX in an Aviary, position control (mode 7), default rates."""

from circle import DURATION_S, START, point, serve

CONTROL_HZ, PHYSICS_HZ = 120, 240  # its defaults


def prepare(drones, _):
    if drones != 1:
        raise SystemExit("fly_pyflyt: one drone only")
    import numpy as np
    from PyFlyt.core import Aviary

    world = Aviary(start_pos=np.array([START]), start_orn=np.zeros((1, 3)), drone_type="quadx", seed=1,
                   drone_options={"drone_model": "cf2x", "control_hz": CONTROL_HZ}, physics_hz=PHYSICS_HZ)

    def fly():
        world.reset()
        world.set_mode(7)
        times, positions = [], []
        for i in range(int(DURATION_S * CONTROL_HZ)):
            x, y, z = point(i / CONTROL_HZ)[0]
            world.set_setpoint(0, np.array([x, y, 0.0, z]))
            world.step()
            times.append((i + 1) / CONTROL_HZ)
            positions.append(world.state(0)[-1])
        return int(DURATION_S * PHYSICS_HZ), times, positions

    return fly


if __name__ == "__main__":
    serve(prepare, __doc__)
