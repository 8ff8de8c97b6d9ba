"""Several threads of Python use one object, and code that an object calls uses it in turn."""

import threading

import highwall as hw
import numpy as np
import pytest
from conftest import moving_wall

RE_ENTRY = "must not call it in turn"


def beside(work, read):
    """Calls read() over and over while work() runs on another thread; what work() returned or raised."""
    results = []

    def run():
        try:
            results.append(work())
        except Exception as error:  # for the thread of the test
            results.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    calls = 0
    while thread.is_alive() or calls == 0:
        read()
        calls += 1
    thread.join()
    if isinstance(results[0], Exception):
        raise results[0]
    return results[0]


class Spring(hw.Factor):
    """A vector, drawn to a place. Calls `then` whenever it is evaluated."""

    def __init__(self, place, then=None):
        super().__init__(len(place), [len(place)])
        self.place, self.then = np.asarray(place, float), then

    def evaluate(self, vector):
        if self.then:
            self.then()
        return vector - self.place, [np.eye(len(vector))]


def test_a_system_is_read_on_one_thread_while_another_tracks(sensor):
    slam = hw.SlamSystem(sensor)

    def track():
        for image in moving_wall(sensor.camera, 30):
            slam.track(*image)
        slam.finish()

    def read():
        assert slam.map_points().shape[1] == 3 and slam.map_lines().shape[1] == 6
        assert len(slam.trajectory()) <= 30 and len(slam.keyframe_trajectory()) <= 30
        slam.sensor(), slam.refined_frames(), slam.factor_counts

    beside(track, read)
    assert len(slam.trajectory()) == 30


def test_callbacks_are_exchanged_on_one_thread_while_another_tracks(sensor):
    slam, frames = hw.SlamSystem(sensor), []

    def track():
        for image in moving_wall(sensor.camera, 30):
            slam.track(*image)

    beside(track, lambda: slam.set_callbacks(on_frame=lambda frame: frames.append(frame.stamp)))
    # From the frame on at which the other thread came in, none is left out.
    assert len(frames) > 1 and len(set(np.diff(frames))) == 1


def test_a_graph_is_changed_on_one_thread_while_another_solves():
    graph = hw.FactorGraph()
    variables = []
    for i in range(50):
        variables.append(graph.add_variable(np.zeros(3)))
        graph.add_factor(Spring([i, 1, 2]), variables[-1])

    def change():
        variable = graph.add_variable(np.zeros(3))
        graph.add_factor(hw.VectorPrior3(np.ones(3), np.eye(3)), variable)
        assert np.isfinite(graph.cost()) and graph.num_factors == graph.num_variables
        graph.value(variables[0])
        graph.remove(variable)

    def solve():
        return [graph.solve() for _ in range(10)]

    assert all(summary.is_usable() for summary in beside(solve, change))
    np.testing.assert_allclose(graph.value(variables[7]), [7, 1, 2], atol=1e-6)


def test_a_smoother_is_changed_on_one_thread_while_another_updates():
    smoother = hw.SlidingWindowSmoother(hw.SlidingWindowOptions(max_states=20))
    lock, stamps = threading.Lock(), iter(range(1, 10**6))

    def add():
        with lock:
            variable = smoother.add_state(next(stamps), np.zeros(3))
            smoother.add_factor(Spring([1, 2, 3]), variable)

    def update():
        return [smoother.update() for _ in range(40)]

    def read():
        add()
        stamps_of_states = smoother.stamps()
        assert stamps_of_states == sorted(stamps_of_states)

    add()
    assert len(beside(update, read)) == 40
    for _ in range(20):
        add()
    assert smoother.update().accepted and len(smoother.stamps()) == 20


def test_keyframes_are_added_on_two_threads(sensor):
    images = list(moving_wall(sensor.camera, 12))
    mapper = hw.DenseMapper(sensor.camera, sensor.depth_noise)

    def add():
        for i, (stamp, bgr, depth) in enumerate(images):
            mapper.add_keyframe(i, stamp, bgr, depth, hw.Pose())

    beside(add, lambda: mapper.set_poses({i: hw.Pose() for i in range(len(images))}))
    (dense,) = mapper.finish()
    np.testing.assert_allclose(dense.cloud.points[:, 2], 2.0, atol=1e-5)


def test_a_pose_graph_is_read_on_one_thread_while_another_solves():
    step = hw.Pose.from_tangent([1, 0, 0], [0, 0, 0.1])
    nodes = [hw.PoseGraphNode(i, hw.Pose(), fixed=i == 0) for i in range(300)]
    odometry = hw.PoseGraphEdgeKind.ODOMETRY
    edges = [hw.PoseGraphEdge(i, i + 1, odometry, step, np.eye(6)) for i in range(299)]
    graph = hw.PoseGraph(nodes, edges)

    def change():
        graph.nodes = graph.nodes
        assert len(graph.nodes) == 300

    beside(lambda: hw.solve_pose_graph(graph), change)


def test_a_callback_that_calls_its_system_is_an_error_not_a_wait(sensor):
    image = next(moving_wall(sensor.camera, 1))
    for call in [
        lambda slam: slam.map_points(),
        lambda slam: slam.trajectory(),
        lambda slam: slam.factor_counts,
        lambda slam: slam.track(10**9, *image[1:]),
        lambda slam: slam.finish(),
        lambda slam: slam.set_callbacks(),
    ]:
        slam = hw.SlamSystem(sensor)
        slam.set_callbacks(on_frame=lambda frame: call(slam))
        with pytest.raises(RuntimeError, match="SlamSystem .*" + RE_ENTRY):
            slam.track(*image)
        assert len(slam.trajectory()) == 1, "the frame was tracked, and the system may be used"


def test_a_callback_may_use_other_objects(sensor):
    slam, other, graph = hw.SlamSystem(sensor), hw.SlamSystem(sensor), hw.FactorGraph()
    images = list(moving_wall(sensor.camera, 3))
    slam.set_callbacks(on_frame=lambda frame: graph.add_variable(float(len(other.trajectory()))))
    for image in images:
        slam.track(*image)
        other.track(*image)
    assert graph.num_variables == 3


@pytest.mark.parametrize("threads", [1, 2])
def test_a_factor_that_calls_its_graph_is_an_error_not_a_wait(threads):
    graph = hw.FactorGraph()
    raised = []

    def call():
        try:
            graph.num_factors
        except RuntimeError as error:
            raised.append(str(error))
            raise

    variable = graph.add_variable(np.zeros(3))
    for i in range(4):
        factor = graph.add_factor(Spring([1, 2, i], call), variable)
    assert not graph.solve(hw.SolveOptions(threads=threads)).is_usable()
    assert raised and all(RE_ENTRY in message and "FactorGraph" in message for message in raised)
    assert RE_ENTRY in graph.fault_of(factor)


def test_a_factor_may_solve_another_graph():
    inner, outer = hw.FactorGraph(), hw.FactorGraph()
    inner.add_factor(Spring([1, 2, 3]), inner.add_variable(np.zeros(3)))
    variable = outer.add_variable(np.zeros(3))
    outer.add_factor(Spring([1, 2, 3], lambda: inner.solve()), variable)
    assert outer.solve(hw.SolveOptions(threads=2)).is_usable()
    np.testing.assert_allclose(outer.value(variable), [1, 2, 3], atol=1e-9)


def test_a_factor_that_calls_its_smoother_is_refused():
    smoother = hw.SlidingWindowSmoother()
    variable = smoother.add_state(0, np.zeros(3))
    smoother.add_factor(Spring([1, 2, 3], smoother.stamps), variable)
    report = smoother.update()
    assert not report.accepted and RE_ENTRY in report.message


@pytest.mark.parametrize("deterministic", [True, False])
def test_a_factor_that_calls_its_system_is_said_and_does_not_wait(sensor, monkeypatch, deterministic):
    raised = []
    monkeypatch.setattr("sys.unraisablehook", lambda error: raised.append(str(error.exc_value)))
    slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=deterministic))

    class Height(hw.Factor):
        def __init__(self):
            super().__init__(1, [hw.Pose])

        def evaluate(self, T_WB):
            slam.finish()

    for image in moving_wall(sensor.camera, 25):
        slam.add_factor([image[0]], Height())
        slam.track(*image)
    slam.finish()
    assert raised and all(RE_ENTRY in message for message in raised)


def test_an_extractor_that_calls_its_system_is_an_error_not_a_wait(sensor):
    class Points(hw.PointExtractor):
        def extract(self, gray):
            slam.map_points()

    slam = hw.SlamSystem(sensor, points=Points("points", 32))
    with pytest.raises(RuntimeError, match=RE_ENTRY):
        slam.track(*next(moving_wall(sensor.camera, 1)))
