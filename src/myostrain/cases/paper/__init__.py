"""What the paper states and what the page says of it, as data; one file per chapter.

``title``, ``introduction``, ``remarks``: of the chapter.
``[claims.NAME]``: ``where``, ``quote``, ``because`` (why these bounds),
``bounds = { number = [least, most] }``, and ``measured``, what was measured in a sentence or two.
``[tables.NAME]``: ``caption``, ``head``.
``[pictures.NAME]``: ``caption``, ``alt`` for those who cannot see it.
``[[differences]]``: ``title``, ``text`` and a ``command`` that shows where paper and numbers differ.
``[verdicts]``: by the name of a claim, what its verdict was when last examined.
``[measured]``: by the name of a number, what the chapter measured when it was last examined: ``value``,
``within`` (absolute, from measured convergence), ``settings`` ("quick" or "full"). The tests assert them.

The words are templates of Jinja: ``{{ celerity.rigid|fixed(2) }}`` is a number of the chapter with two
decimals; :mod:`myostrain.reproduce.words` has the filters.

Source: D. Ambrosi, G. Arioli, F. Nobile, A. Quarteroni, SIAM J. Appl. Math. 71(2), 2011,
doi 10.1137/100788379.
"""
