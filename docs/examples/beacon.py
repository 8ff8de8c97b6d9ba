"""Finds a body by its distances from three beacons, with a factor written in Python."""

import highwall as hw
import numpy as np


class BeaconRange(hw.Factor):
    """The distance [m] from the body to a beacon."""

    def __init__(self, distance, beacon_W, sigma):
        super().__init__(1, [hw.Pose])  # residuals, types of the values
        self.distance, self.beacon_W, self.sigma = distance, np.asarray(beacon_W), sigma

    def evaluate(self, T_WB):
        way = T_WB.p - self.beacon_W
        distance = np.linalg.norm(way)
        J = np.zeros((1, 6))  # in the tangent [dp dtheta]
        J[0, :3] = way / distance / self.sigma
        return [(distance - self.distance) / self.sigma], [J]


graph = hw.FactorGraph()
pose = graph.add_variable(hw.Pose())
graph.add_factor(hw.PosePrior(hw.Pose(), np.diag([0.1, 0.1, 0.1, 100, 100, 100])), pose)
for beacon, distance in [((5, 0, 0), 4.0), ((0, 5, 0), 5.0), ((0, 0, 5), 5.0)]:
    factor = BeaconRange(distance, beacon, 0.05)
    assert hw.check_jacobians(factor, hw.Pose([0.3, 0, 0], [0, 0, 0, 1]))
    graph.add_factor(factor, pose, loss=hw.HuberLoss(2.0))
print(graph.solve(), graph.value(pose))
