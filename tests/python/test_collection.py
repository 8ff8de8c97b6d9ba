"""Cycles through callbacks, factors and extractors are freed; what is in use is kept."""

import gc
import os
import pathlib
import subprocess
import sys
import threading
import time
import weakref

import highwall as hw
import numpy as np
import pytest
from conftest import moving_wall


class Hold(hw.Factor):
    """A position at the origin. May hold whatever it is a part of."""

    def __init__(self, part_of=None):
        super().__init__(3, [hw.Pose])
        self.part_of = part_of

    def evaluate(self, T_WB):
        return T_WB.p, [np.eye(3, 6)]


class Nothing(hw.PointExtractor):
    def __init__(self):
        super().__init__("nothing", 32)

    def extract(self, gray):
        return [], []


class App:
    """Owns a system, whose callbacks are its methods."""

    def __init__(self, sensor, *names):
        self.frames = []
        self.slam = hw.SlamSystem(sensor)
        self.slam.set_callbacks(**{name: self.frame for name in names})

    def frame(self, *arguments):
        self.frames.append(len(arguments))


def is_freed(make):
    """Whether all that make() returns is freed once nothing else refers to it."""
    gc.collect()
    alive = [weakref.ref(made) for made in make()]
    for _ in range(200):
        gc.collect()
        if [ref() for ref in alive] == [None] * len(alive):
            return True
        time.sleep(0.05)  # a thread of the system may be in a factor
    return False


@pytest.mark.parametrize("name", ["on_keyframe", "on_loop", "on_map", "on_frame"])
def test_a_system_whose_callback_is_a_method_of_its_owner_is_freed(sensor, name):
    def make():
        app = App(sensor, name)
        app.slam.track(*next(moving_wall(sensor.camera, 1)))
        return app, app.slam

    assert is_freed(make)


def test_the_threads_of_a_system_in_a_cycle_end(sensor):
    def threads():
        with open("/proc/self/status") as status:
            return int(next(line for line in status if line.startswith("Threads:")).split()[1])

    def make():
        app = App(sensor, "on_frame")
        for image in moving_wall(sensor.camera, 3):
            app.slam.track(*image)
        return (app,)

    is_freed(make)  # what is started once for all
    before = threads()
    for _ in range(5):
        assert is_freed(make)
    assert threads() <= before


def test_callbacks_that_were_replaced_are_freed_and_those_in_use_kept(sensor):
    slam, frames = hw.SlamSystem(sensor), []

    class Listener:
        def frame(self, frame):
            frames.append(frame.stamp)

    first, second = Listener(), Listener()
    slam.set_callbacks(on_frame=first.frame)
    slam.set_callbacks(on_frame=second.frame)
    alive = weakref.ref(first), weakref.ref(second)
    del first, second
    gc.collect()
    assert alive[0]() is None and alive[1]() is not None
    slam.track(*next(moving_wall(sensor.camera, 1)))
    assert frames == [0]
    slam.set_callbacks()
    assert alive[1]() is None


def test_a_system_that_is_its_own_listener_or_extractor_is_freed(sensor):
    class System(hw.SlamSystem):
        def __init__(self):
            super().__init__(sensor)
            self.set_callbacks(on_frame=self.frame)

        def frame(self, frame):
            pass

    class Points(Nothing):
        def __init__(self):
            super().__init__()
            self.slam = hw.SlamSystem(sensor, points=self)

    class Both(hw.SlamSystem, hw.PointExtractor):
        def __init__(self):
            hw.PointExtractor.__init__(self, "nothing", 32)
            hw.SlamSystem.__init__(self, sensor, points=self)

        def extract(self, gray):
            return [], []

    def points():
        made = Points()
        made.slam.track(*next(moving_wall(sensor.camera, 1)))
        return made, made.slam

    assert is_freed(lambda: (System(),))
    assert is_freed(points)
    assert is_freed(lambda: (Both(),))


def test_a_graph_whose_factor_holds_it_is_freed():
    def graph():
        made = hw.FactorGraph()
        factor = Hold(made)
        made.add_factor(factor, made.add_variable(hw.Pose()))
        assert made.solve().is_usable()
        return made, factor

    def smoother():
        made = hw.SlidingWindowSmoother()
        factor = Hold([made])
        made.add_factor(factor, made.add_state(0, hw.Pose()))
        assert made.update().accepted
        return made, factor

    assert is_freed(graph)
    assert is_freed(smoother)


@pytest.mark.parametrize("deterministic", [True, False])
def test_a_system_whose_factors_hold_it_is_freed(sensor, deterministic):
    def make():
        slam = hw.SlamSystem(sensor, hw.SlamOptions(deterministic=deterministic))
        factors = []
        for image in moving_wall(sensor.camera, 10):
            factors.append(Hold(slam))
            slam.add_factor([image[0]], factors[-1])
            slam.track(*image)
        return slam, *factors

    assert is_freed(make)


def test_factors_of_a_graph_in_use_are_kept_and_those_that_are_removed_freed():
    graph = hw.FactorGraph()
    pose = graph.add_variable(hw.Pose([1, 2, 3], [0, 0, 0, 1]))
    factors = [Hold(graph), Hold(graph)]
    alive = [weakref.ref(factor) for factor in factors]
    first = graph.add_factor(factors[0], pose)
    graph.add_factor(factors[1], pose)
    del factors
    gc.collect()
    assert None not in [ref() for ref in alive]
    graph.remove_factor(first)
    assert alive[0]() is None and alive[1]() is not None
    assert graph.solve().is_usable()
    np.testing.assert_allclose(graph.value(pose).p, 0, atol=1e-9)


def test_what_is_left_of_a_cycle_may_still_be_used_by_its_finalizers(sensor):
    said = []

    class Owner(App):
        def __del__(self):
            self.slam.track(*next(moving_wall(sensor.camera, 1)))
            said.append(len(self.slam.trajectory()))

    assert is_freed(lambda: (Owner(sensor, "on_frame"),))
    assert said == [1]


def test_an_object_that_was_not_made_is_collected(sensor):
    class Unmade(hw.SlamSystem):
        def __init__(self):
            self.cycle = self
            gc.collect()  # there is no system yet
            super().__init__("no sensor")

    for _ in range(3):
        with pytest.raises(TypeError):
            Unmade()
    gc.collect()
    hw.FactorGraph.__new__(hw.FactorGraph)
    gc.collect()


def test_the_collector_runs_while_threads_track_and_solve(sensor):
    def track():
        for _ in range(3):
            app = App(sensor, "on_frame", "on_keyframe")
            for image in moving_wall(sensor.camera, 10):
                app.slam.add_factor([image[0]], Hold(app))
                app.slam.track(*image)
            assert len(app.frames) >= 10

    def solve():
        for _ in range(30):
            graph = hw.FactorGraph()
            for _ in range(5):
                graph.add_factor(Hold(graph), graph.add_variable(hw.Pose([1, 2, 3], [0, 0, 0, 1])))
            assert graph.solve(hw.SolveOptions(threads=2)).is_usable()

    threads = [threading.Thread(target=track), threading.Thread(target=solve)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        gc.collect()
    for thread in threads:
        thread.join()


def test_a_program_ends_while_threads_of_its_system_evaluate_in_python(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        """
import time
import highwall as hw
import numpy as np
from conftest import moving_wall


class Slow(hw.Factor):
    def __init__(self):
        super().__init__(3, [hw.Pose])

    def evaluate(self, T_WB):
        time.sleep(0.002)
        return T_WB.p, [np.eye(3, 6)]


camera = hw.PinholeCamera(width=320, height=240, fx=262.5, fy=262.5, cx=159.5, cy=119.5)
slam = hw.SlamSystem(hw.RgbdSensor(camera=camera))
for image in moving_wall(camera, 25):
    slam.add_factor([image[0]], Slow())
    slam.track(*image)
print("end")
"""
    )
    folders = [pathlib.Path(__file__).parent, pathlib.Path(hw.__file__).parents[1]]
    environment = {**os.environ, "PYTHONPATH": ":".join(map(str, folders))}
    for _ in range(5):
        ran = subprocess.run([sys.executable, program], capture_output=True, text=True, env=environment)
        assert (ran.returncode, ran.stdout, ran.stderr) == (0, "end\n", "")
