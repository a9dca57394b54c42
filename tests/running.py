"""Runs studies in tests: with other tasks than their own, in this process."""

from dataclasses import replace

from linecontact.studies.runner.run import run_study


def run_plans(study, plans, folder, **options):
    """Run a study with these plans instead of its own; returns the exit status."""
    return run_study(
        replace(study, plans=lambda _: plans), study.options(**{"folder": folder, "workers": 1, **options})
    )
