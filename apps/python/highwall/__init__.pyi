"""Types of the module, for editors and mypy. tests/python/test_module.py holds them against it."""

from ._estimation import *
from ._factors import *
from ._geometry import *
from ._mapping import *
from ._slam import *
from ._trajectory import *

__version__: str

class InvalidArgument(ValueError): ...

class IoError(OSError): ...
