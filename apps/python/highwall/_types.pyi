"""What arrays, paths and values of variables may be given as."""

import os
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._geometry import OrthonormalLine, Pose, Segment3, UnitDirection

Array = npt.NDArray[Any]
Path = Union[str, "os.PathLike[str]"]
Value = Union[Pose, OrthonormalLine, Segment3, UnitDirection, float, npt.ArrayLike]
