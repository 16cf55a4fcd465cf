"""Sizes of objects by class, known before they are observed."""

import numpy as np

from vpf_sim.configuration import setting, settings
from vpf_sim.types import Floats


@settings
class ObjectSizes:
    """Lengths of objects by width: of most only the face is observed."""

    length_m: float = setting("Length of a narrow object.", default=1.0, gt=0.0)
    car_width_m: float = setting("Width from which an object may be a car.", default=1.0, gt=0.0)
    car_length_m: float = setting("Length of a car.", default=5.5, gt=0.0)
    truck_width_m: float = setting("Width from which an object may be a truck.", default=2.25, gt=0.0)
    truck_length_m: float = setting("Length of a truck.", default=9.0, gt=0.0)

    def __post_init__(self) -> None:
        if not self.car_width_m < self.truck_width_m:
            raise ValueError(f"car_width_m: expected < truck_width_m = {self.truck_width_m}, got {self.car_width_m}")

    def lengths_m(self, width_m: Floats) -> Floats:
        """(K,) largest lengths of objects of these widths (K,)."""
        wide = [width_m > self.truck_width_m, width_m > self.car_width_m]
        return np.select(wide, [self.truck_length_m, self.car_length_m], self.length_m)
