"""Angular contact ball bearings of high-speed spindles: equilibrium, exact stiffness, life.

>>> import spindle_bearing as sb
>>> spindle = sb.Spindle.read("spindle.toml")
>>> spindle.solve(fy=[0, 250, 500], rpm=12000).stiffness[:, 1, 1]  # N/m

Frame: outer rings stand still, the shaft turns about +x. Loads are N and N m, displacements m and rad, each in the order
x, y, z, about y, about z. The equations are those of ``docs/model.md`` of the project.
"""

from ._core import bearings
from ._errors import SpindleError
from ._result import Result, Row
from ._spindle import Spindle

__all__ = ["Result", "Row", "Spindle", "SpindleError", "bearings"]
