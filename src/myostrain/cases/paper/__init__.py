"""What the paper states, as data: its words, where they stand, and what bears them out; a file a chapter.

``[claims.NAME]``: ``where``, ``quote``, ``because`` (why these bounds),
``bounds = { number = [least, most] }``.
``[verdicts]``: by the name of a claim, what its verdict was when last examined.
``[measured]``: by the name of a number, what the chapter measured when it was last examined: ``value``,
``within`` (absolute, from measured convergence), ``settings`` ("quick" or "full"). The tests assert them.

Source: D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.
"""
