"""Heights that are missing, stand for missing ones, or stick out like dust: found, and filled or left out."""

from typing import Literal

import numpy as np
from linecontact.solver.arrays import Array64, Indices, Mask

Missing = Literal["interpolate", "drop", "refuse"]

LONGEST_GAP = 0.05  # share of a scan that may be without values in one place
DOUBTED = 0.01  # share of a scan that may be filled without a warning
_ISOLATED = 0.5  # ranges of all other values, between them and a number that stands for missing ones
_RARE = 0.99  # quantile that is called usual
_SPIKE = 3  # values in the width of a spike
_HIGH, _UNLIKE, _MANY = 2.0, 4.5, 0.8  # rms heights, and times that quantile of heights above valleys on both sides
_TEXTURE, _REGULAR = 0.05, 0.3  # share of the values, and of the mean distance of theirs: a grating
_STEP, _FEW = 10.0, 3  # times the usual step, for up to so many that stand alone


def marked(z: Array64, numbers: str) -> Mask:
    """Where heights are numbers that the user says are none, like "-9999,-32768". Raises `ValueError`."""
    said = np.zeros(z.size, dtype=np.bool_)
    for word in numbers.split(","):
        try:
            found = np.isclose(z, float(word), rtol=1e-9, atol=0.0)
        except ValueError:
            found = np.zeros(z.size, dtype=np.bool_)
        if not found.any():
            raise ValueError(f"invalid is {numbers!r}; allowed: numbers among the heights, like -9999 or -9999,-1")
        said |= found
    return said


def filled(values: Array64, how: Missing) -> tuple[Array64, str]:
    """Rows of position and height, or height alone, without those that miss one, and the changes, in words.

    Raises `ValueError` for a gap that is too long to be filled.
    """
    there, count = np.flatnonzero(~np.isnan(values).any(axis=1)), len(values)
    if there.size == count:
        return values, ""
    told = f"{count - there.size} of {count} values were missing and"
    if how == "drop" or np.isnan(values[:, :-1]).any():
        return values[there], f"{told} left out"
    if (longest := int(np.diff(there, prepend=-1, append=count).max()) - 1) > LONGEST_GAP * count:
        seen = f"{longest} of {count} values are missing in one place"
        raise ValueError(f"{seen}; allowed: up to {LONGEST_GAP:.0%}, cut the scan")
    *x, z = values.T
    at = np.abs(x[0] - x[0][0]) if x else np.arange(count)
    return np.stack([*x, np.interp(at, at[there], z[there])], axis=1), f"{told} filled by straight lines"


def doubtful(z: Array64, despiked: bool) -> list[tuple[Indices, str]]:
    """Indices of heights, shape (values,) [any unit], that may be none, with reasons; despiked: --despike is given."""
    numbers, reason = _sentinels(z), "may stand for missing values (--invalid) or be dust (--despike)"
    found = [(np.flatnonzero(z == number), reason) for number in numbers]
    there = np.flatnonzero(~np.isin(z, numbers))
    found.append((there[spikes(z[there])], "stand out as spikes (--despike)"))
    steps = np.abs(np.diff(z[there]))
    jumps = np.flatnonzero(steps > max(_STEP * float(np.quantile(steps, _RARE)), float(z[there].std())))
    if jumps.size <= _FEW:
        found.append((there[1:][jumps], "begin behind a step that stands alone"))
    return [(rows, reason.replace(" (--despike)", "") if despiked else reason) for rows, reason in found if rows.size]


def spikes(z: Array64, both: bool = False) -> Indices:
    """Indices of values that stand out by themselves: upwards, where they would carry the load alone, or both ways."""
    kept = np.ones(z.size, dtype=np.bool_)
    while (there := np.flatnonzero(kept)).size > _SPIKE:
        level = z[there] - np.polynomial.Polynomial.fit(there, z[there], 2)(there)
        high = _stand_out(level) | (_stand_out(-level) if both else False)
        if not high.any():
            break
        kept[there[high]] = False
    found = np.flatnonzero(~kept)
    apart = np.diff(found[np.diff(found, prepend=-2) > 1])
    many = found.size > _TEXTURE * z.size and apart.size > 1
    return found[:0] if many and apart.std() < _REGULAR * apart.mean() else found


def _stand_out(level: Array64) -> Mask:
    """Whether heights are far above the valleys on both sides, compared with most others."""
    windows = np.lib.stride_tricks.sliding_window_view
    lowest = windows(np.pad(level, _SPIKE, constant_values=level.min()), _SPIKE + 1).min(axis=1)
    above = level - windows(lowest, _SPIKE + 1).max(axis=1)
    return np.asarray(above > max(_HIGH * float(level.std()), _UNLIKE * float(np.quantile(above, _MANY))))


def _sentinels(z: Array64) -> Array64:
    """Up to three of the lowest and of the highest numbers, if they are isolated from all others."""
    values = np.unique(z)
    few = min(_FEW, (values.size - 1) // 3)
    apart = np.flatnonzero(np.diff(values) > _ISOLATED * np.ptp(values[few : values.size - few]))
    low, high = apart[apart < few].max(initial=-1), apart[apart >= values.size - 1 - few].min(initial=values.size)
    return np.concatenate([values[: low + 1], values[high + 1 :]])
