"""Flies crazyflow's Crazyflie along the circle on the CPU: one world step by step, or a whole flight as one compiled function."""

import os

os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

from circle import DURATION_S, START, point, serve  # noqa: E402

STATE_HZ, PHYSICS_HZ = 100, 500  # its defaults


def prepare(drones, whole):
    """Step by step as in its quick start; or through its functional interface, the whole flight in one lax.scan."""
    import jax
    import jax.numpy as jnp
    import numpy as np
    from crazyflow.control import Control
    from crazyflow.sim import Sim
    from crazyflow.sim import functional

    sim = Sim(n_worlds=drones, n_drones=1, drone="cf2x_L250", control=Control.state, freq=PHYSICS_HZ, state_freq=STATE_HZ)
    sim.reset()
    # at the reference, the rotors as fast as in hover: thrust of one = a + b n + c n²
    states, params = sim.data.states, sim.data.params
    a, b, c = np.asarray(params.rpm2thrust, dtype=float).ravel()
    weight = float(np.ravel(params.mass)[0]) * 9.81
    hover_rpm = (-b + np.sqrt(b * b - 4.0 * c * (a - weight / 4.0))) / (2.0 * c)
    begin = sim.data.replace(states=states.replace(pos=jnp.broadcast_to(jnp.asarray(START, states.pos.dtype), states.pos.shape),
                                                   rotor_vel=jnp.full_like(states.rotor_vel, hover_rpm)))
    moments = int(DURATION_S * STATE_HZ)
    commands = np.zeros((moments, 1, 1, 16), dtype=np.float32)
    for i in range(moments):
        commands[i, 0, 0, :9] = np.concatenate(point(i / STATE_HZ))
    commands[..., 12] = 1.0  # level
    times = [(i + 1) / STATE_HZ for i in range(moments)]
    steps = PHYSICS_HZ // STATE_HZ

    def one_by_one():
        sim.data = begin
        positions = []
        for command in commands:
            sim.state_control(command)
            sim.step(steps)
            positions.append(sim.data.states.pos)
        return moments * steps, times, np.asarray(jnp.stack(positions))[:, -1, 0]

    step = sim.build_step_fn()

    @jax.jit
    def flight(data, commands):
        def next_moment(data, command):
            data = functional.state_control(data, jnp.broadcast_to(command, (drones, 1, 16)))
            data = step(data, steps)
            return data, data.states.pos[-1, 0]

        return jax.lax.scan(next_moment, data, commands)

    def at_once():
        _, positions = jax.block_until_ready(flight(begin, commands))
        return moments * steps, times, np.asarray(positions)

    return at_once if whole else one_by_one


if __name__ == "__main__":
    serve(prepare, __doc__)
