"""Factor-graph RGB-D-inertial SLAM with points and lines.

Numbers, vectors and matrices are NumPy arrays, stamps integers [ns], lengths metres, angles
radians. Images are arrays as OpenCV has them: colour height x width x 3 of uint8 (BGR), depth
height x width of float32 [m]. Frames and signs: docs/conventions.md. A bad argument raises
InvalidArgument (a ValueError), a bad file IoError (an OSError).
"""

from ._highwall import *
from ._highwall import __version__
