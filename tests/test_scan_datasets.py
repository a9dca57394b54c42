"""Scans in HDF5 datasets: attributes that change the numbers or name their unit."""

import h5py
import numpy as np
import pytest
from linecontact import read_scan

UM = {"scan_length": 2e-4, "num_points": 512}


@pytest.fixture
def counts():
    return np.random.default_rng(3).integers(-9000, 9000, 512).astype(np.int16)


def stored(folder, values, attributes, group=None):
    path = folder / "scan.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(group or {})
        file["line"] = values
        file["line"].attrs.update(attributes)
    return path


def test_counts_are_unpacked(tmp_path, counts):
    """By the CF conventions: an int16 dataset would be read 10^4 times too high."""
    packed = {"units": "um", "scale_factor": 1e-4, "add_offset": 0.5, "_FillValue": np.int16(-9999)}
    scan = read_scan(stored(tmp_path, counts, packed), window="none", detrend="none", **UM)
    np.testing.assert_allclose(scan.indenter.heights, (counts.max() - counts) * 1e-10, atol=1e-18)


def test_fill_values_are_missing(tmp_path, counts):
    counts[100] = -9999
    packed = {"units": "um", "scale_factor": 1e-4, "_FillValue": np.int16(-9999)}
    path = stored(tmp_path, counts, packed)
    with pytest.raises(ValueError, match="row 101: a value is missing, and 1 of 512"):
        read_scan(path, **UM)
    assert read_scan(path, missing="interpolate", **UM).indenter.heights.max() < 4e-6


@pytest.mark.parametrize(
    ("attributes", "group", "options", "named"),
    [
        ({"units": "um", "gain": 2.0}, {}, {}, "attribute 'gain' may change it"),
        ({"units": "um", "scale_factor": "big"}, {}, {}, "attribute scale_factor is big"),
        ({"units": "um"}, {"scale_factor": 2.0}, {}, "in a group whose attribute 'scale_factor' may change it"),
        ({"units": "um"}, {}, {"z_unit": "nm"}, "z_unit is nm, but the file names um"),
        ({}, {"z_units": "nm"}, {"z_unit": "um"}, "z_unit is um, but the file names nm"),
        ({"units": "V"}, {}, {"z_unit": "um"}, "'line .V.', are no lengths for 'V'"),
    ],
)
def test_attributes_that_are_not_understood_or_contradict(tmp_path, counts, attributes, group, options, named):
    with pytest.raises(ValueError, match=named):
        read_scan(stored(tmp_path, counts, attributes, group), **UM, **options)
