"""Ctrl-C, and what else ends a program, gets through code that a solver or a system calls."""

import os
import signal
import sys
import threading
import time

import highwall as hw
import numpy as np
import pytest
from conftest import moving_wall


def ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(10)  # on the main thread it does not last: KeyboardInterrupt


class Interrupted(hw.Factor):
    """A factor of a number or a pose, whose evaluation number `at` is interrupted."""

    def __init__(self, variable=1, end=ctrl_c, at=3):
        super().__init__(1, [variable])
        self.columns = 6 if variable is hw.Pose else 1
        self.end, self.at, self.calls = end, at, 0

    def evaluate(self, value):
        self.calls += 1
        if self.calls == self.at:
            self.end()
        return [float(np.ravel(getattr(value, "p", value))[0]) ** 2 + 1], [np.full((1, self.columns), 0.1)]


def graph_of(factor):
    graph = hw.FactorGraph()
    return graph, graph.add_factor(factor, graph.add_variable(np.array([3.0])))


def test_ctrl_c_within_a_factor_comes_out_of_solve():
    factor = Interrupted()
    graph, _ = graph_of(factor)
    with pytest.raises(KeyboardInterrupt):
        graph.solve()
    assert factor.calls < 10, "what was left to do was not done"
    assert graph.solve().is_usable(), "once"


@pytest.mark.parametrize(
    "ask",
    [
        lambda graph, factor: graph.cost(),
        lambda graph, factor: graph.fault_of(factor),
        lambda graph, factor: graph.squared_error(factor),
        lambda graph, factor: graph.covariance(),
    ],
    ids=["cost", "fault_of", "squared_error", "covariance"],
)
def test_ctrl_c_within_a_factor_comes_out_of_whatever_evaluates_it(ask):
    graph, factor = graph_of(Interrupted(at=1))
    with pytest.raises(KeyboardInterrupt):
        ask(graph, factor)


def test_ctrl_c_within_a_factor_comes_out_of_check_jacobians_and_update():
    with pytest.raises(KeyboardInterrupt):
        hw.check_jacobians(Interrupted(), np.array([3.0]))
    smoother = hw.SlidingWindowSmoother()
    smoother.add_factor(Interrupted(), smoother.add_state(0, np.array([3.0])))
    with pytest.raises(KeyboardInterrupt):
        smoother.update()


def test_what_ends_a_program_gets_through_and_errors_are_faults_as_before():
    class Own(BaseException):
        pass

    def exits():
        sys.exit(7)

    def own():
        raise Own("own")

    def error():
        raise RuntimeError("no beacon")

    with pytest.raises(SystemExit, match="7"):
        graph_of(Interrupted(end=exits))[0].solve()
    with pytest.raises(Own, match="own"):
        graph_of(Interrupted(end=own))[0].solve()
    graph, factor = graph_of(Interrupted(end=error, at=1))
    assert "no beacon" in graph.fault_of(factor)


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit])
def test_what_ends_a_program_gets_through_from_a_thread_of_the_solver(end):
    def raises():
        raise end

    graph = hw.FactorGraph()
    for _ in range(20):
        graph.add_factor(Interrupted(end=raises, at=2), graph.add_variable(np.array([3.0])))
    with pytest.raises(end):
        graph.solve(hw.SolveOptions(threads=4))


def interrupted_after(seconds, work):
    """The time [s] that work() took when Ctrl-C ended it."""
    timer = threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
            timer.join()  # too late to be of use
            time.sleep(1)
        return time.monotonic() - begin
    finally:
        timer.join()


def ring(size):
    """Poses on a ring, all begun at one place: far from solved."""
    step = hw.Pose.from_tangent([1, 0, 0], [0, 0, 2 * np.pi / size])
    return step, 100 * np.eye(6)


def test_ctrl_c_ends_a_long_solve_of_factors_of_the_library():
    graph, poses = hw.FactorGraph(), []
    random = np.random.default_rng(1)
    step, information = ring(4000)
    for _ in range(4000):
        poses.append(graph.add_variable(hw.Pose.from_tangent(random.normal(size=3), random.normal(size=3))))
    for a, b in zip(poses, poses[1:] + poses[:1]):
        graph.add_factor(hw.RelativePose(step, information), a, b)
    graph.fix(poses[0])
    options = hw.SolveOptions(max_iterations=100_000, function_tolerance=0, parameter_tolerance=0, gradient_tolerance=0)
    assert interrupted_after(0.3, lambda: graph.solve(options)) < 3
    assert np.isfinite(graph.cost())


def test_ctrl_c_ends_a_long_solve_of_a_pose_graph_and_leaves_it_as_it_was():
    random = np.random.default_rng(1)
    step, information = ring(4000)
    nodes = [
        hw.PoseGraphNode(i, hw.Pose.from_tangent(random.normal(size=3), random.normal(size=3)), fixed=i == 0)
        for i in range(4000)
    ]
    kind = hw.PoseGraphEdgeKind
    edges = [hw.PoseGraphEdge(i, i + 1, kind.ODOMETRY, step, information) for i in range(3999)]
    edges.append(hw.PoseGraphEdge(3999, 0, kind.LOOP, step, information))
    graph = hw.PoseGraph(nodes, edges)
    before = hw.chi2(graph)
    options = hw.PoseGraphOptions(solver=hw.SolveOptions(
        max_iterations=100_000, function_tolerance=0, parameter_tolerance=0, gradient_tolerance=0
    ))
    assert interrupted_after(0.3, lambda: hw.solve_pose_graph(graph, options)) < 3
    assert hw.chi2(graph) == before


def test_ctrl_c_comes_out_of_track_and_the_system_continues(sensor):
    slam = hw.SlamSystem(sensor)
    images = list(moving_wall(sensor.camera, 20))

    def track():
        for image in images[:10]:
            slam.track(*image)
        while True:
            slam.trajectory()

    interrupted_after(0.2, track)
    for image in images[10:]:
        assert slam.track(*image).state == hw.TrackingState.TRACKING


@pytest.mark.parametrize("name", ["on_frame", "on_keyframe"])
def test_ctrl_c_within_a_callback_comes_out_of_track(sensor, name):
    slam = hw.SlamSystem(sensor)
    slam.set_callbacks(**{name: lambda *arguments: ctrl_c()})
    with pytest.raises(KeyboardInterrupt):
        slam.track(*next(moving_wall(sensor.camera, 1)))


@pytest.mark.parametrize("end", [ctrl_c, sys.exit])
def test_what_ends_a_program_within_a_factor_comes_out_of_track(sensor, monkeypatch, end):
    swallowed = []
    monkeypatch.setattr("sys.unraisablehook", swallowed.append)
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=True))
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        for image in moving_wall(sensor.camera, 25):
            slam.add_factor([image[0]], Interrupted(hw.Pose, end, at=1))
            slam.track(*image)
        slam.finish()
    assert not swallowed
