"""Finds the packages: linecontact, which is api/, and in it every folder with Python of kernels/, solver/, studies/."""

from setuptools import find_packages, setup

folders = find_packages(include=["kernels*", "solver*", "studies*"])
setup(packages=["linecontact", *(f"linecontact.{folder}" for folder in folders)])
