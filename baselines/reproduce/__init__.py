"""The paper's figures and tables, reproduced: ``python -m baselines.reproduce``.

``contents`` lists all that is made, in order. A module named by a figure draws it, or computes what
it shows; the caption is the docstring of the function that makes it. The studies are
``single_runs`` of Figs. 6 to 9, the trials of Fig. 10, ``planner_comparison`` (two arcs against the
Dubins path) and ``claims`` (claims of the paper put to the test).
"""
