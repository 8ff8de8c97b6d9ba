"""What comes with the module: documentation, types, the example."""

import ast
import os
import pathlib
import re
import subprocess
import sys

import highwall as hw
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_every_name_has_a_type_for_editors():
    written = {}
    stubs = [ast.parse(path.read_text()) for path in pathlib.Path(hw.__file__).parent.glob("*.pyi")]
    for node in [node for stub in stubs for node in stub.body]:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            written[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            written[node.target.id] = node
    assert public(vars(hw)) == public(written)
    for name, node in written.items():
        if isinstance(node, ast.ClassDef):
            members = {
                n.target.id if isinstance(n, ast.AnnAssign) else n.name
                for n in node.body
                if isinstance(n, (ast.AnnAssign, ast.FunctionDef))
            }
            assert public(vars(getattr(hw, name))) == public(members), name


def test_every_class_and_function_says_what_it_is():
    silent = [name for name in public(vars(hw)) if callable(getattr(hw, name)) and not getattr(hw, name).__doc__]
    assert not silent


def test_the_example_runs(tmp_path):
    example = subprocess.run(
        [sys.executable, ROOT / "docs/examples/slam.py", "--out", tmp_path], capture_output=True, text=True
    )
    assert example.returncode == 0, example.stderr
    assert "20 frames with a pose" in example.stdout
    assert (tmp_path / "cloud.ply").stat().st_size > 0 and (tmp_path / "map.bt").stat().st_size > 0


@pytest.mark.parametrize("version", ["2.0.0", "2.3.1", "2.0.0rc1", "10.1"])
def test_numpy_that_pybind11_does_not_know_is_an_error_at_import(tmp_path, version):
    if tuple(map(int, hw._highwall._pybind11_version.split("."))) >= (2, 12):
        pytest.skip("built with a pybind11 that knows NumPy 2")
    (tmp_path / "numpy").mkdir()
    (tmp_path / "numpy/__init__.py").write_text(f"__version__ = {version!r}\n")
    module = pathlib.Path(hw.__file__).parents[1]
    tried = subprocess.run(
        [sys.executable, "-c", "import highwall"], capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": f"{tmp_path}:{module}"}
    )
    assert tried.returncode == 1, "it did not crash, and was not imported"
    assert "ImportError: this module of Highwall was built with pybind11 2." in tried.stderr
    assert f"arrays of NumPy {version}: install 'numpy<2'" in tried.stderr


def run_example(name):
    path = ROOT / "docs/examples" / name
    scope = {}
    exec(compile(path.read_text(), path, "exec"), scope)
    return scope


def test_the_example_of_an_extractor_tracks():
    grey = np.random.default_rng(2).integers(0, 256, (480, 640), dtype=np.uint8)
    depth = np.full(grey.shape, 2.0, np.float32)
    frame = run_example("corners.py")["slam"].track(0, np.dstack([grey] * 3), depth)
    assert frame.points == 500 and frame.state == hw.TrackingState.TRACKING


def test_the_example_of_a_factor_finds_the_body():
    scope = run_example("beacon.py")
    found = scope["graph"].value(scope["pose"]).p
    assert abs(found[0] - 1.0) < 0.1 and abs(found[1]) < 0.2


@pytest.mark.parametrize("name", ["beacon.py", "corners.py"])
def test_the_page_shows_excerpts_of_the_example(name):
    page, program = ((ROOT / "docs" / path).read_text() for path in ("python.md", f"examples/{name}"))
    block = page.split(f"](examples/{name})", 1)[1].split("```python\n", 1)[1].split("```")[0]
    for excerpt in re.split(r"^ *# \.\.\.\n", block, flags=re.MULTILINE):
        before, found, program = program.partition("\n" + excerpt)
        assert found, f"docs/examples/{name} does not have, in this order:\n{excerpt}"
