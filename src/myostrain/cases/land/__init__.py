"""What is published of the cases of Land et al. 2015, and converged values, as data; one file per case.

``[quantities.NAME]``: a coordinate (``axis``) of the deformed position of a material ``point``; ``what`` it
is; ``published``, least and largest value, and ``source``; ``converged``, the value that finer and finer
meshes tend to.
``[lines.NAME]``: material ``points`` of which the deformed positions are kept in ``lines.csv``, and
``converged``, these positions on a fine mesh.
``[strains]``: true where the lines are those of a wall, the same number of points from apex to base on each
from the inside to the outside: strains along, around and through it follow from their positions.

The converged values of problems 2 and 3 are those of ``tests/reference/land_axisymmetric.py``, which solves
them as what they are, axisymmetric (with a twist in problem 3).

Source: S. Land and others, Proc. R. Soc. A 471 (2015) 20150641, doi 10.1098/rspa.2015.0641.
"""
