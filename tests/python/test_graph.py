"""Graphs, with factors that are written in Python."""

import threading
import weakref

import highwall as hw
import numpy as np
import pytest


class Range(hw.Factor):
    """The distance [m] from a pose to a known point."""

    def __init__(self, distance, point):
        super().__init__(1, [hw.Pose])
        self.distance, self.point = distance, np.asarray(point, float)

    def evaluate(self, pose):
        way = pose.p - self.point
        distance = np.linalg.norm(way)
        return [distance - self.distance], [np.hstack([way / distance, np.zeros(3)])[np.newaxis]]


def located(truth, add):
    """A graph with a pose that is held by four ranges; add(graph, factor, pose)."""
    graph = hw.FactorGraph()
    pose = graph.add_variable(hw.Pose.from_tangent([0.5, 0.5, 0.5], np.zeros(3)))
    graph.add_factor(hw.PosePrior(hw.Pose(), np.diag([0, 0, 0, 1.0, 1, 1])), pose)
    for point in ([5, 0, 0], [0, 5, 1], [-4, 1, 5], [0, -5, 2]):
        add(graph, Range(np.linalg.norm(truth - point), point), pose)
    return graph, pose


def test_a_factor_in_python_finds_the_pose():
    truth = np.array([0.3, -0.2, 0.1])
    graph, pose = located(truth, lambda graph, factor, pose: graph.add_factor(factor, pose))
    assert hw.check_jacobians(Range(1.0, [1, 2, 3]), graph.value(pose))
    summary = graph.solve(hw.SolveOptions(parameter_tolerance=1e-12, function_tolerance=1e-15))
    assert summary.is_usable()
    np.testing.assert_allclose(graph.value(pose).p, truth, atol=1e-9)
    assert graph.covariance(pose).shape == (6, 6)
    loose = graph.add_variable(1.0)
    assert graph.covariance(loose) is None
    assert "is in no factor" in graph.undetermined()


def test_factors_in_python_work_with_several_threads_and_losses():
    truth = np.array([0.3, -0.2, 0.1])
    loss = hw.HuberLoss(1.0)
    graph, pose = located(truth, lambda graph, factor, pose: graph.add_factor(factor, pose, loss=loss))
    done = threading.Event()
    other = threading.Thread(target=done.set)  # runs while the solver has given the lock away
    other.start()
    assert graph.solve(hw.SolveOptions(threads=2)).is_usable()
    assert done.wait(10)
    np.testing.assert_allclose(graph.value(pose).p, truth, atol=1e-6)


def test_a_factor_lives_as_long_as_its_graph():
    graph = hw.FactorGraph()
    pose = graph.add_variable(hw.Pose())
    factor = Range(1.0, [2, 0, 0])
    alive = weakref.ref(factor)
    graph.add_factor(factor, pose)
    del factor
    assert alive() is not None
    assert graph.cost() == pytest.approx(0.5)
    graph.remove(pose)
    del graph
    assert alive() is None


def test_what_a_factor_raises_is_said_and_leaves_the_values():
    class Broken(hw.Factor):
        def __init__(self):
            super().__init__(1, [3])

        def evaluate(self, point):
            raise RuntimeError("the beacon is off")

    graph = hw.FactorGraph()
    point = graph.add_variable(np.array([1.0, 2, 3]))
    broken = graph.add_factor(Broken(), point)
    assert "the beacon is off" in graph.fault_of(broken)
    assert not graph.solve().is_usable()
    np.testing.assert_array_equal(graph.value(point), [1, 2, 3])
    with pytest.raises(hw.InvalidArgument):
        graph.cost()


def test_wrong_shapes_of_a_factor_are_named():
    class Wrong(hw.Factor):
        def __init__(self):
            super().__init__(1, [hw.Pose])

        def evaluate(self, pose):
            return [0.0], [np.zeros((1, 7))]

    graph = hw.FactorGraph()
    factor = graph.add_factor(Wrong(), graph.add_variable(hw.Pose()))
    assert "1 x 6" in graph.fault_of(factor)
    with pytest.raises(hw.InvalidArgument, match="type"):
        hw.Factor(1, ["pose"])


@pytest.mark.parametrize(
    "value", [1.5, np.array([1.0, 2, 3]), np.arange(9.0)], ids=["number", "vector", "longer vector"]
)
def test_a_variable_comes_back_as_what_it_was(value):
    graph = hw.FactorGraph()
    variable = graph.add_variable(value)
    np.testing.assert_array_equal(graph.value(variable), value)
    assert type(graph.value(variable)) is type(value)
    graph.set_value(variable, 2 * value)
    np.testing.assert_array_equal(graph.value(variable), 2 * value)
    with pytest.raises(hw.InvalidArgument, match="another type"):
        graph.set_value(variable, hw.Pose())


def test_a_handle_of_another_graph_is_refused():
    graph, other = hw.FactorGraph(), hw.FactorGraph()
    variable = graph.add_variable(1.0)
    with pytest.raises(hw.InvalidArgument):
        other.value(variable)
    with pytest.raises(hw.InvalidArgument):
        graph.add_variable(np.zeros(17))


def test_the_smoother_keeps_a_window_and_its_prior(tmp_path):
    smoother = hw.SlidingWindowSmoother(hw.SlidingWindowOptions(max_states=3))
    step = hw.Pose.from_tangent([0.1, 0, 0], [0, 0, 0.05])
    information = 10 * np.eye(6)
    pose, before = hw.Pose(), None
    for i in range(8):
        variable = smoother.add_state(i * 1_000_000_000, pose)
        if before is None:
            smoother.add_factor(hw.PosePrior(hw.Pose(), 100 * np.eye(6)), variable)
        else:
            smoother.add_factor(hw.RelativePose(step, information), before, variable)
        report = smoother.update()
        assert report.accepted, report.message
        before, pose = variable, smoother.value(variable) * step
    assert smoother.stamps() == [5_000_000_000, 6_000_000_000, 7_000_000_000]
    expected = hw.Pose()
    for _ in range(7):
        expected = expected * step
    np.testing.assert_allclose(smoother.value(before).p, expected.p, atol=1e-9)
    covariance = smoother.covariance(before)
    smoother.save(tmp_path / "window")
    again = hw.SlidingWindowSmoother.load(tmp_path / "window")
    assert again.stamps() == smoother.stamps()
    assert np.all(np.linalg.eigvalsh(covariance) > 0)


def test_a_pose_graph_closes_its_loop_and_refuses_a_false_one(tmp_path):
    step = hw.Pose.from_tangent([1, 0, 0], [0, 0, np.pi / 4])
    drift = step * hw.Pose.from_tangent([0.02, 0, 0], [0, 0, 0.01])
    nodes = [hw.PoseGraphNode(0, hw.Pose(), fixed=True)]
    edges = []
    kind = hw.PoseGraphEdgeKind
    for i in range(8):
        nodes.append(hw.PoseGraphNode(i + 1, nodes[-1].pose * drift))
        edges.append(hw.PoseGraphEdge(i, i + 1, kind.ODOMETRY, step, 100 * np.eye(6)))
    edges.append(hw.PoseGraphEdge(0, 8, kind.LOOP, hw.Pose(), 1e4 * np.eye(6)))
    # A false loop: the two are 2.4 m apart.
    edges.append(hw.PoseGraphEdge(2, 6, kind.LOOP, hw.Pose(), 1e4 * np.eye(6)))
    graph = hw.PoseGraph(nodes, edges)
    hw.write_g2o(tmp_path / "loop.g2o", graph)
    again = hw.read_g2o(tmp_path / "loop.g2o")
    assert [edge.kind for edge in again.edges] == [edge.kind for edge in edges]
    summary = hw.solve_pose_graph(graph, hw.PoseGraphOptions(robust=hw.RobustLoops.GNC))
    assert [loop.edge for loop in summary.rejected] == [9]
    # Odometry and the true loop agree: eight turns of 45 degrees close.
    np.testing.assert_allclose(graph.nodes[8].pose.p, 0, atol=1e-6)
    assert hw.pose_graph_covariance(graph, [8], without=[9]).shape == (6, 6)
    assert hw.pose_graph_covariance(graph, [8], without=list(range(10))) is None
    with pytest.raises(hw.InvalidArgument):
        hw.pose_graph_covariance(graph, [4711])
