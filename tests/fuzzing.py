"""What the tests with random files and arguments share."""

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

HEIGHTS = np.sin(np.arange(40.0))
fuzz = settings(
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def mutants(content):
    """Valid content with a few bytes changed, cut out, put in or repeated."""

    def change(edits):
        data = bytearray(content)
        for place, length, new in edits:
            place = place % (len(data) + 1)
            data[place : place + length] = new
        return bytes(data)

    return st.lists(st.tuples(st.integers(0, 2**20), st.integers(0, 64), st.binary(max_size=16)), max_size=4).map(
        change
    )
