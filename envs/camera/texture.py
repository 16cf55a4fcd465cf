"""Periodic band-limited noise, the grain of all surfaces."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from vpf_sim.seeding import stream
from vpf_sim.types import Floats

TILE = 1024  # texels
ROUNDED = 2.0**-20


def noise(shape: tuple[int, int], rng: np.random.Generator, shortest: float, slope: float) -> Floats:
    """Periodic Gaussian noise, mean 0, sd 1, without wavelengths below `shortest` texels.

    Its amplitude falls with the frequency f as f^-slope. Computed in doubles, and rounded far above their last bits, so
    that it is the same on every processor.
    """
    spectrum = fft.rfft2(rng.standard_normal(shape, dtype=np.float32).astype(np.float64))
    spectrum *= _amplitudes(shape, shortest, slope)
    spectrum[0, 0] = 0.0
    field = fft.irfft2(spectrum, s=shape)
    return np.asarray(np.round(field / field.std() / ROUNDED) * ROUNDED)


@lru_cache(maxsize=4)
def _amplitudes(shape: tuple[int, int], shortest: float, slope: float) -> Floats:
    """Of the spectrum of real noise. Cached: every sky has noise of the same kinds."""
    frequency = np.hypot(fft.fftfreq(shape[0])[:, None], fft.rfftfreq(shape[1])[None, :])
    frequency[0, 0] = 1.0
    return np.asarray(frequency**-slope * np.exp(-((frequency * shortest) ** 4)))


@lru_cache(maxsize=8)
def grain_tile(name: str, shortest: float = 3.0, slope: float = 0.6, sd: float = 40.0) -> NDArray[np.uint8]:
    """(2 TILE, 2 TILE) the grain `name` about 128, repeated twice each way.

    The same in every episode; a seed only places it. Cached, since it costs 50 ms.
    """
    field = noise((TILE, TILE), stream(0, f"grain {name}"), shortest, slope)
    tile = np.clip(128.5 + sd * field, 0, 255).astype(np.uint8)
    return np.tile(tile, (2, 2))
