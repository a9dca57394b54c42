"""The kind of processor."""

import platform
import re
from functools import cache
from pathlib import Path

_CPUINFO = Path("/proc/cpuinfo")
_NUMBERS = {"cpu family": "family", "model": "model", "stepping": "stepping"}
_NUMBERS |= {f"CPU {what}": what for what in ("implementer", "part", "variant", "revision")}  # of ARM
_SETS = re.compile(r"(sse4_2|avx|avx2|fma|avx512\w+|neon|asimd|sve\d?)$")


def processor() -> str:
    """Name of the processor, with family, model and stepping where the system tells: a name alone may be of many."""
    about = _about()
    name = about.get("model name") or platform.processor() or platform.machine()
    numbers = [f"{label} {about[key]}" for key, label in _NUMBERS.items() if key in about]
    return f"{name} ({', '.join(numbers)})" if numbers else name


def instructions() -> str:
    """The sets of vector instructions that it has; empty where the system does not tell."""
    about = _about()
    words = (about.get("flags") or about.get("Features") or "").split()
    return " ".join(sorted(word for word in words if _SETS.match(word)))


@cache
def _about() -> dict[str, str]:
    """The system's description of the first core."""
    try:
        lines = [line.partition(":") for line in _CPUINFO.read_text().split("\n\n")[0].splitlines()]
    except OSError:
        return {}
    return {name.strip(): value.strip() for name, _, value in lines}
