"""Flies RotorPy's Crazyflie along the circle: Environment.run() for one drone, simulate_batch() for more."""

from circle import DURATION_S, HEIGHT_M, PERIOD_S, RADIUS_M, START, serve

RATE_HZ = 100  # its default
HOVER_RADPS = 1788.53  # of its examples


def one():
    import numpy as np
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.environments import Environment
    from rotorpy.trajectories.circular_traj import ThreeDCircularTraj
    from rotorpy.vehicles.crazyflie_params import quad_params
    from rotorpy.vehicles.multirotor import Multirotor

    state = {"x": np.array(START), "v": np.zeros(3), "q": np.array([0, 0, 0, 1]), "w": np.zeros(3), "wind": np.zeros(3),
             "rotor_speeds": np.full(4, HOVER_RADPS)}
    path = ThreeDCircularTraj(center=np.array([0.0, 0.0, HEIGHT_M]), radius=np.array([RADIUS_M, RADIUS_M, 0.0]),
                              freq=np.array([1.0, 1.0, 0.0]) / PERIOD_S)
    environment = Environment(vehicle=Multirotor(quad_params, initial_state=state), controller=SE3Control(quad_params),
                              trajectory=path, sim_rate=RATE_HZ)

    def fly():
        flown = environment.run(t_final=DURATION_S, terminate=False, plot=False)
        return len(flown["time"]) - 1, flown["time"], flown["state"]["x"]

    return fly


def many(drones):
    import numpy as np
    import torch
    from rotorpy.controllers.quadrotor_control import BatchedSE3Control
    from rotorpy.sensors.imu import BatchedImu
    from rotorpy.simulate import simulate_batch
    from rotorpy.trajectories.circular_traj import BatchedThreeDCircularTraj
    from rotorpy.vehicles.crazyflie_params import quad_params
    from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams
    from rotorpy.wind.default_winds import BatchedNoWind
    from rotorpy.world import World

    torch.set_num_threads(1)
    device = torch.device("cpu")

    def rows(values):
        return torch.tensor(values, dtype=torch.double, device=device).repeat(drones, 1)

    start = {"x": rows(START), "v": rows([0.0] * 3), "q": rows([0.0, 0.0, 0.0, 1.0]), "w": rows([0.0] * 3), "wind": rows([0.0] * 3),
             "rotor_speeds": rows([HOVER_RADPS] * 4)}
    params = BatchedMultirotorParams([dict(quad_params) for _ in range(drones)], drones, device)
    path = BatchedThreeDCircularTraj(np.tile([0.0, 0.0, HEIGHT_M], (drones, 1)), np.tile([RADIUS_M, RADIUS_M, 0.0], (drones, 1)),
                                     np.tile([1.0 / PERIOD_S, 1.0 / PERIOD_S, 0.0], (drones, 1)), [False] * drones)
    controller = BatchedSE3Control(params, drones, device=device)
    world = World.empty((-3, 3, -3, 3, -3, 3))

    class Path:
        """The simulator gives one time for each drone as an array of NumPy, where the path computes with tensors."""

        def update(self, t):
            flat = path.update(torch.as_tensor(t, device=device))
            return {key: torch.as_tensor(value, device=device) for key, value in flat.items()}

    def fly():
        # rk4: "much faster" than dopri5, say its examples
        vehicle = BatchedMultirotor(params, drones, start, device=device, integrator="rk4")
        flown = simulate_batch(world, start, vehicle, controller, Path(), BatchedNoWind(drones),
                               BatchedImu(drones, sampling_rate=RATE_HZ, device=device), np.full(drones, DURATION_S),
                               1.0 / RATE_HZ, 0.25, terminate=False, check_collisions=False)
        positions = flown[1]["x"][:, -1]
        return len(positions) - 1, [i / RATE_HZ for i in range(len(positions))], positions

    return fly


if __name__ == "__main__":
    serve(lambda drones, _: one() if drones == 1 else many(drones), __doc__)
