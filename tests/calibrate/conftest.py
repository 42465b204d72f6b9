"""Made calibrations: distances, files of a common error, readings along a known line."""

import numpy as np
import pytest

from robustnav.calibrate import Pairs


@pytest.fixture
def made():
    """Return a function that draws pairs along r = slope d + offset with white and with common errors of each file."""

    def draw(rng, *, files=20, each=10, sd=0.05, file_sd=0.0, slope=1.004, offset=0.08, d=None):
        d = np.linspace(2, 60, files) if d is None else d
        file = np.repeat(np.arange(len(d)), each)
        d = d[file]
        common = file_sd * rng.standard_normal(files)[file]
        return Pairs(d, slope * d + offset + common + sd * rng.standard_normal(len(d)), file=file)

    return draw
