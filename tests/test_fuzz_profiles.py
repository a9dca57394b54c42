"""Profile files from anywhere: each is read or refused in one line, never a traceback, a hang or a crash.

The cases are what longer runs have found; a short run of each kind, with fixed seeds, goes on looking.
"""

import contextlib
import io
import sys

import h5py
import numpy as np
import pytest
from fuzzing import HEIGHTS, fuzz, mutants
from hypothesis import given, settings
from hypothesis import strategies as st
from linecontact.solver import Scene, solve
from linecontact.studies.files import solution_files
from linecontact.studies.scans import columns, text
from linecontact.studies.scans.reading import Options
from linecontact.studies.scans.reading import read as read_options


def read(path, content=None, **options):
    if content is not None:
        path.write_bytes(content)
    options = {"scene_units": True} | options
    try:
        return read_options(Options(path, **options))
    except ValueError as error:
        if "scan_length is missing" not in str(error):
            raise
    return read_options(Options(path, **options, scan_length=1.0))


def scene(path, content):
    indenter, period, n = read(path, content)
    return Scene(indenter=indenter, period=period, num_points=n)


def header(text):
    text = text.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npz(array):
    file = io.BytesIO()
    np.savez(file, array)
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}"), "damaged"),
        (header("{'descr': '<f8', 'fortran_order': False, 'shape': (16,)}"), "damaged"),
        (header("{'descr': '|V0', 'fortran_order': False, 'shape': (16,)}"), "real numbers"),
        (header("(" * 60), "damaged"),
        (npz(HEIGHTS), "damaged"),
        (npy(HEIGHTS.astype(complex)), "complex128"),
        (npy(np.zeros(40, [("x", "f8"), ("z", "f8")])), "real numbers"),
        (npy(np.array(1.0)), r"shape \(\)"),
        (npy(np.zeros((0, 2))), "damaged|shape"),
        (npy(1e308 * np.sign(HEIGHTS)), r"e\+308; allowed: finite numbers up to 1e\+100"),
        (npy(5e-324 * np.arange(40.0) % 1e-322), "height ranges from"),
        (npy(np.stack([np.append(np.arange(39.0), np.inf), HEIGHTS], 1)), "row 40: x is text or inf; allowed: finite"),
        (npy(np.stack([np.append(-1e308, np.linspace(1, 1e308, 39)), HEIGHTS], 1)), r"row 1: x is -1e\+308"),
    ],
)
def test_arrays_that_are_none(tmp_path, content, named):
    with pytest.raises(ValueError, match=named):
        scene(tmp_path / "scan.npy", content)


def test_arrays_in_any_order_are_read(tmp_path):
    table = np.stack([np.arange(40.0), HEIGHTS], 1)
    expected, *_ = read(tmp_path / "scan.npy", npy(table))
    for array in (np.asfortranarray(table), table.astype(">f8"), table.astype(np.longdouble)):
        found, *_ = read(tmp_path / "scan.npy", npy(array))
        np.testing.assert_allclose(found.heights, expected.heights, atol=1e-14)


def test_what_is_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(columns, "MAX_VALUES", 39)
    monkeypatch.setattr(text, "MAX_TEXT", 1000)
    with pytest.raises(ValueError, match=r"40 numbers; allowed: .* up to 39"):
        read(tmp_path / "scan.npy", npy(HEIGHTS))
    with pytest.raises(ValueError, match="allowed: 1000 bytes"):
        read(tmp_path / "scan.csv", b"1\n2\n" * 251)
    with h5py.File(tmp_path / "scan.h5", "w") as file:
        file["line"] = HEIGHTS
    with pytest.raises(ValueError, match=r"shape \(40,\); allowed: up to 39"):
        read(tmp_path / "scan.h5")


@pytest.mark.parametrize("content", [b"1 " * 10**6, b"\0" * 1000, b"\xff\xfe" + "a\nb\n".encode("utf-16le") * 40])
def test_text_that_is_none(tmp_path, content):
    with pytest.raises(ValueError, match=r"no table|columns is missing"):
        read(tmp_path / "scan.txt", content)


def refused_or_read(path, content):
    """A few thousand of them were tried once; what is read must be a profile."""
    with contextlib.suppress(ValueError):
        assert scene(path, content).profile.min() == 0


TEXT = b"x;z\n" + "".join(f"{i};{z:.3f}\n" for i, z in enumerate(HEIGHTS)).encode()


@settings(fuzz, max_examples=150)
@given(st.one_of(mutants(TEXT), st.binary(max_size=300), st.text("0123456789.,;-+eE_naif \n\r\0", max_size=400)))
def test_any_text(tmp_path, content):
    refused_or_read(tmp_path / "scan.csv", content if isinstance(content, bytes) else content.encode())


@settings(fuzz, max_examples=150)
@given(st.one_of(mutants(npy(HEIGHTS)), mutants(npy(np.stack([np.arange(40.0), HEIGHTS], 1))), st.binary(max_size=200)))
@pytest.mark.filterwarnings("ignore::UserWarning", "ignore::SyntaxWarning", "ignore::DeprecationWarning")
def test_any_array(tmp_path, content):
    refused_or_read(tmp_path / "scan.npy", content)


def one_dataset():
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        file.create_dataset("line", data=HEIGHTS, chunks=(16,), compression="gzip", shuffle=True)
        file.flush()
        return file.id.get_file_image()


@settings(fuzz, max_examples=6)
@given(mutants(one_dataset()))
def test_any_hdf5(tmp_path, content):
    refused_or_read(tmp_path / "scan.h5", content)


@pytest.mark.skipif(sys.platform != "linux", reason="names of any bytes")
def test_names_that_are_no_text(tmp_path):
    path = tmp_path / "b\udc80.csv"
    indenter, period, n = read(path, "".join(f"{i} {z}\n" for i, z in enumerate(HEIGHTS)).encode(), num_points=40)
    solution = solve(Scene(indenter=indenter, period=period, num_points=n))
    solution_files.save_solution(tmp_path / "run\udc80.h5", solution)
    assert solution_files.load(tmp_path / "run\udc80.h5").results["scene.profile_file"] == "b\\x80.csv"
