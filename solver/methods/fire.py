"""Plain FIRE, the published study's method, as a choice; `fire_state` is how it works."""

from .fire_state import Fire
from .method import MethodKind
from .rebased_fire import begin_fire

KIND = MethodKind(
    name="fire",
    label="plain FIRE",
    begin=lambda problem, config: begin_fire(Fire, problem, config),
    max_iterations=200_000,
    precisions=("float64", "float32", "mixed"),
    devices=("cpu", "cuda"),
    grows=True,
    share=0.15,
)
