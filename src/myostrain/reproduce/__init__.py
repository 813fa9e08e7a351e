"""The paper, reproduced and judged: ``myostrain reproduce``.

A chapter names its jobs and turns their outcomes into statements, tables and pictures; a verdict is a
function of measured numbers and of the claims in ``cases/paper``; the page shows what there is.
"""

from myostrain.reproduce.build import reproduce

__all__ = ["reproduce"]
