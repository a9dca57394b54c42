"""Finds the packages: every folder of kernels/, solver/ and studies/ that holds Python, under the name linecontact."""

from setuptools import find_packages, setup

FOLDERS = ("kernels", "solver", "studies")

setup(packages=[f"linecontact.{name}" for name in find_packages(include=[f"{folder}*" for folder in FOLDERS])])
