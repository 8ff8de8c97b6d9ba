"""Highwall as a baseline of VSLAM-LAB: goes to Baselines/baseline_files/ there (README.md)."""
import shutil

from Baselines.BaselineVSLAMLab import BaselineVSLAMLab


class HIGHWALL_baseline(BaselineVSLAMLab):
    """highwall slam with an RGB-D camera and, in the mode rgbd-vi, its IMU."""

    def __init__(self):
        super().__init__("highwall", "highwall")
        self.default_parameters = {"mode": "rgbd", "verbose": 0, "switches": ""}
        self.modes = ["rgbd", "rgbd-vi"]
        self.camera_models = self.cam_models = ["pinhole", "radtan4", "radtan5"]
        self.command_style = "python"  # --key value

    def build_execute_command(self, exp_it, exp, dataset, sequence_name):
        # Versions with command_style build the command themselves.
        build = getattr(super(), "build_execute_command_python", super().build_execute_command)
        return build(exp_it, exp, dataset, sequence_name)

    def has_source(self):
        return shutil.which("highwall") is not None  # a package: there is no source to fetch

    def is_installed(self):
        found = self.has_source()
        return found, "is installed" if found else "add highwall and run_highwall to PATH"
