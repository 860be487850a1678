"""The paper's figures and table made anew: ``python -m baselines.reproduce``.

What is made, in order, is listed in ``contents``:

* ``definitions`` Figs. 1-2, ``approach`` Figs. 3-4, ``paths`` Fig. 5 and the poses within reach
* ``runs`` the runs of Figs. 6-9, ``states`` their figures, ``trials`` Fig. 10 and the table
* ``planners`` two arcs against the Dubins path, ``claims`` and ``attribution`` the paper's claims

``worlds`` runs episodes, ``statistics`` sums them up, ``style`` and ``drawing`` say how figures
look, ``artefact`` and ``record`` how files are written and kept, ``page`` puts the table into a
page for readers. A figure's caption is the docstring of the function that makes it.
"""
