"""Results without a grid: closed forms and limits, and collocation for one asperity.

Every error of the grid methods is measured against these. They know the bonded layer and power profiles only.

May import: arrays, checks, transforms, layers.
"""
